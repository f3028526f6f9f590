/* `tmdempm steer`: talks to a run through the socket in its folder. */
#ifndef TMDEMPM_RUN_STEER_CLI_H
#define TMDEMPM_RUN_STEER_CLI_H

/* argv[0] = "steer".  Answers go to stdout.  Returns a status; error_message() tells what was wrong. */
int cli_steer(int argc, char **argv);

#endif
