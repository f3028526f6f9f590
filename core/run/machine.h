/* The machine that this program runs on. */
#ifndef TMDEMPM_RUN_MACHINE_H
#define TMDEMPM_RUN_MACHINE_H

struct machine {
	char processor[128];
	char isa[64];  /* the vector instruction sets that matter: "avx2 fma avx512f" */
	int threads;   /* that OpenMP would use */
	double memory; /* bytes installed */
};

void machine_look(struct machine *machine);

#endif
