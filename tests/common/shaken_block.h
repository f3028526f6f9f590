/* A free block of an elastic solid (h = 1, E = 1, rho = 1) somewhere on the grid, with velocities and strains at
 * random, so weak that nothing moves: every mode of the scheme has its share.  Include after <cmocka.h> and
 * elastic_scene.h. */
#ifndef TESTS_COMMON_SHAKEN_BLOCK_H
#define TESTS_COMMON_SHAKEN_BLOCK_H

struct shaken_block {
	const char *shape;
	int points_per_cell;
	int columns, rows; /* of points */
	double offset[2];  /* of the lattice, in cells */
	double poisson;
	double drift; /* of the block along x, over c */
	double shake; /* velocity over c, strain */
};

/* c dt / h = courant; c = sqrt(M / rho). */
static inline struct scene *shaken_scene(struct elastic_scene *s, const struct shaken_block *b, double courant)
{
	double nu = b->poisson, modulus = (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu)), c = sqrt(modulus);
	double spacing = 1.0 / sqrt(b->points_per_cell), x = 3.0 + b->offset[0], y = 3.0 + b->offset[1];
	int cells_x = (int)(b->columns * spacing + (b->drift > 0.0 ? 12.0 : 6.0)) + 1;
	struct scene *scene = elastic_scene_init(s, cells_x, (int)(b->rows * spacing) + 7, 1.0, 1.0, nu, 1.0, courant / c);
	snprintf(scene->mpm.shape, sizeof scene->mpm.shape, "%s", b->shape);
	s->laws[0].thermoelastic.neo_hookean = true; /* has no bound of its own that would hide the others */
	struct scene_body *body =
		elastic_scene_box(s, b->points_per_cell, x, y, x + b->columns * spacing, y + b->rows * spacing);
	body->lattice_origin[0] = b->offset[0], body->lattice_origin[1] = b->offset[1];
	body->velocity[0] = b->drift * c;
	return scene;
}

static inline void shake(struct mpm *mpm, const struct shaken_block *b)
{
	double c = sqrt(mpm->p.modulus[0]);
	unsigned long long random = 12345;
	for (int k = 0; k < mpm->p.n; k++)
		for (int i = 0; i < 6; i++) {
			random = random * 6364136223846793005ULL + 1442695040888963407ULL;
			double push = b->shake * ((double)(random >> 33) / 4294967296.0 - 0.25) * 4.0;
			*(i < 2 ? &mpm->p.v[k][i] : &mpm->p.F[k][i - 2]) += (i < 2 ? c : 1.0) * push;
		}
}

static inline double largest_stress(const struct mpm *mpm)
{
	double most = 0.0;
	for (int k = 0; k < mpm->p.n; k++)
		for (int c = 0; c < 4; c++)
			most = isfinite(mpm->p.stress[k][c]) ? fmax(most, fabs(mpm->p.stress[k][c])) : INFINITY;
	return most;
}

#endif
