/* `tmdempm rve show` and `tmdempm rve extract`: RVEs of a run, looked at and taken out. */
#ifndef TMDEMPM_RUN_LOOK_CLI_H
#define TMDEMPM_RUN_LOOK_CLI_H

#include <stdbool.h>

/* Is it a verb of these? */
bool cli_look_has(const char *verb);

/* argv[0] = the verb, then its options.  Messages about failures go to stderr.  Returns the exit code. */
int cli_look(int argc, char **argv);

#endif
