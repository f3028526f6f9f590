/* `tmdempm doctor`: tries everything that a run may need on this machine, and says what to do where it does not work. */
#ifndef TMDEMPM_RUN_DOCTOR_H
#define TMDEMPM_RUN_DOCTOR_H

/* Each part is tried in a process of its own, which is ended after `timeout` s.  STATUS_RESOURCE if a plain run (no
 * pictures, no GPU) would not work here. */
int run_doctor(double timeout);

#endif
