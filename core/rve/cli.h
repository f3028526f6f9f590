/* `tmdempm rve pack|load|info`: packings made, driven alone and looked at. */
#ifndef TMDEMPM_RVE_CLI_H
#define TMDEMPM_RVE_CLI_H

/* argv[0] = "rve", argv[1] = the verb, then its options.  Prints what it has to say; messages about
 * failures go to stderr.  Returns the exit code (enum status). */
int cli_rve(int argc, char **argv);

#endif
