/* `tmdempm fragments`: pieces and cracks of a run that is done. */
#ifndef TMDEMPM_RUN_FRAGMENTS_CLI_H
#define TMDEMPM_RUN_FRAGMENTS_CLI_H

/* argv[0] = "fragments", then its options.  Returns a status. */
int cli_fragments(int argc, char **argv);

#endif
