/* The description of one field: a single table of these drives HDF5, .vtp, frames and `info`. */
#ifndef TMDEMPM_BASE_FIELD_H
#define TMDEMPM_BASE_FIELD_H

struct field {
	const char *name; /* lower case with underscores; also the HDF5 dataset and the VTK array */
	const char *unit; /* SI; "-" if dimensionless; "T" = the scene's temperature unit (K inside) */
	int components;   /* 1 scalar, 3 vector (x, y, 0), 6 symmetric tensor (xx yy zz xy yz xz) */
	const char *doc;
};

#endif
