#include "mpm/scheme.h"

#include <stddef.h>

#define TRANSFERS(ENTRY)                                                                                               \
	ENTRY("flip",                                                                                                      \
		  "points keep their velocity and add the nodes' change, with a share of PIC; no loss, but noise that "        \
		  "the nodes cannot see stays")                                                                                \
	ENTRY("xpic", "FLIP whose points keep of their velocity only what the nodes can see, to the order xpic_order; "    \
				  "order 1 is PIC (Hammerquist and Nairn 2017)")                                                       \
	ENTRY("fmpm", "the nodes' velocity after the step, sharpened towards the full mass matrix to the order "           \
				  "xpic_order; order 1 is PIC (Nairn and Hammerquist 2021)")                                           \
	ENTRY("apic", "the nodes' velocity after the step with its affine part; keeps angular momentum, no noise "         \
				  "(Jiang and others 2015)")

#define ORDERS(ENTRY)                                                                                                  \
	ENTRY("usl", "stress last, from the nodes' velocities after the step")                                             \
	ENTRY("usf", "stress first, from the nodes' velocities before the step")                                           \
	ENTRY("musl", "stress last, from the points' new velocities mapped back to the nodes")

#define ROW(name, doc) {name, doc},
#define NAME(name, doc) name,

const struct mpm_scheme mpm_transfers[] = {TRANSFERS(ROW){NULL, NULL}};
const struct mpm_scheme mpm_orders[] = {ORDERS(ROW){NULL, NULL}};
const char *const mpm_transfer_names[] = {TRANSFERS(NAME) NULL};
const char *const mpm_order_names[] = {ORDERS(NAME) NULL};
