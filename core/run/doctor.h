/* `tmdempm doctor`: tries everything that a run may need on this machine, and says what to do where it does not work. */
#ifndef TMDEMPM_RUN_DOCTOR_H
#define TMDEMPM_RUN_DOCTOR_H

/* Tries the n named parts, all for n = 0; each in a process of its own, which is ended after `timeout` s.
 * STATUS_RESOURCE if one does not work that a plain run (no pictures, no GPU) needs; STATUS_INPUT for unknown names. */
int run_doctor(double timeout, int n, char *const *names);

#endif
