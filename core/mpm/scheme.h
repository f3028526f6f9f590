/* How velocities go from the nodes to the points, and when stresses are updated. */
#ifndef TMDEMPM_MPM_SCHEME_H
#define TMDEMPM_MPM_SCHEME_H

enum mpm_transfer { MPM_FLIP, MPM_XPIC, MPM_FMPM, MPM_APIC };
enum mpm_order { MPM_USL, MPM_USF, MPM_MUSL };

struct mpm_scheme {
	const char *name;
	const char *doc;
};

/* Every one there is, in the order of the enums, name = NULL at the end. */
extern const struct mpm_scheme mpm_transfers[], mpm_orders[];

/* Their names alone, NULL-terminated: what a scene can say. */
extern const char *const mpm_transfer_names[], *const mpm_order_names[];

#endif
