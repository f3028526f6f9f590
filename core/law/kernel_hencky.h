/* The Hencky kind of thermoelastic.c.  Included by kernel_text.h only. */

enum { HENCKY_STATE = sizeof(struct thermoelastic_state) / sizeof(double) };
_Static_assert(HENCKY_STATE == 4, "the state is one record");

/* ln V = 1/2 ln b of deformation gradients: (xx, yy, xy); log_left_stretch() with its trace, ln J. */
VECFN void vec_log_left_stretch(const vec F[4], vec ln_j, vec h[3])
{
	vec bxx = F[0] * F[0] + F[1] * F[1], byy = F[2] * F[2] + F[3] * F[3], bxy = F[0] * F[2] + F[1] * F[3];
	vec m = 0.5 * (bxx + byy), d = 0.5 * (bxx - byy), im = 1.0 / m;
	vec k = 0.5 * im * vec_atanh_ratio((d * d + bxy * bxy) * im * im);
	h[0] = 0.5 * ln_j + k * d;
	h[1] = 0.5 * ln_j - k * d;
	h[2] = k * bxy;
}

/* Where are the elastic principal stretches (h: xx, yy, xy, less the thermal strain) not to be trusted? */
VECFN mask hencky_invalid(const vec h[3], vec thermal_strain)
{
	vec mean = 0.5 * (h[0] + h[1]) - thermal_strain, d = 0.5 * (h[0] - h[1]);
	vec room = vec_min(HENCKY_MOST - mean, mean - HENCKY_LEAST), r2 = d * d + h[2] * h[2];
	return mask_or(mask_or(mask_above(vec_set(0.0), room), mask_above(r2, room * room)),
				   mask_different(r2 - r2, room - room));
}

/* One vector; `time` > 0: a step. */
VECFN void hencky_members(const struct law *law, struct law_batch *batch, double time, struct members *members)
{
	const struct thermoelastic_model *m = law->model;
	vec F[4], s[4], h[3], stress[4];
	vec_deformation(batch, members, F);
	vec_of_states(law->states, HENCKY_STATE, 0, members, s); /* warming, pressure, elastic, expansion */
	vec before = s[0], warming = before;
	if (time > 0.0)
		warming = before + vec_of(batch->dT, &members->points);
	else
		warming = before + 0.0;
	vec J = F[0] * F[3] - F[1] * F[2], ij = 1.0 / J, ln_j = vec_log_by_ratio(J);
	vec_log_left_stretch(F, ln_j, h);
	fail(members, mask_or(hencky_invalid(h, m->expansion * warming), ~mask_above(J, vec_set(0.0))));
	vec iso = m->lambda * ln_j - m->thermal * warming;
	vec xx = iso + 2.0 * m->mu * h[0], yy = iso + 2.0 * m->mu * h[1], xy = 2.0 * m->mu * h[2];
	vec zz = m->lambda_zz * ln_j - m->thermal_zz * warming, pressure = xx + yy + zz;
	stress[0] = xx * ij, stress[1] = yy * ij, stress[2] = zz * ij, stress[3] = xy * ij;
	/* compression stiffens: d tau/d ln V - tau bounds the acoustic tensor */
	vec least = vec_min(xx, yy) - vec_magnitude(xy);
	put_response(batch, members, stress, (m->modulus - vec_min(least, vec_set(0.0))) * ij, vec_set(0.0));
	/* elastic strains e = h - alpha dT; out of the plane what plane strain holds back, or what makes zz vanish */
	vec free_strain = m->expansion * warming, exx = h[0] - free_strain, eyy = h[1] - free_strain, ezz;
	if (m->lambda_zz != 0.0 || m->thermal_zz != 0.0)
		ezz = m->expansion_zz * warming;
	else
		ezz = -m->lambda_3d / (m->lambda_3d + 2.0 * m->mu) * (exx + eyy);
	vec e = exx + eyy + ezz;
	s[2] = 0.5 * m->lambda_3d * e * e + m->mu * (exx * exx + eyy * eyy + ezz * ezz + 2.0 * h[2] * h[2]);
	/* of the free thermal strain, by the mean of the stresses before and after: exact along a straight path */
	s[3] -= 0.5 * (s[1] + pressure) * m->expansion * (warming - before);
	s[0] = warming, s[1] = pressure;
	put_states(law->states, HENCKY_STATE, 0, members, s);
}

static int hencky(const struct law *law, struct law_batch *batch, double time, int from, int to)
{
	int failed = to;
	for (int k = from; k < to; k += VECTOR_WIDTH) {
		struct members members = members_of(batch, k, to);
		hencky_members(law, batch, time, &members);
		int first = first_failed(&members, to);
		failed = first < failed ? first : failed;
	}
	return failed;
}
