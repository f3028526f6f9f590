/* The response of neohookean_rankine.c.  Included by kernel_text.h only. */

enum { RANKINE_STATE = sizeof(struct rankine_state) / sizeof(double) };
_Static_assert(RANKINE_STATE == 12 && offsetof(struct rankine_state, softening) == 4 * sizeof(double) &&
				   offsetof(struct rankine_state, elastic) == 8 * sizeof(double),
			   "the state is three records");

/* What the whole material would answer. */
struct whole {
	vec xx, yy, zz, xy; /* Pa, tau0 */
	vec mean, radius;   /* Pa, of its principal values in the plane */
	vec psi;            /* J/m3 */
	vec slope;          /* Pa, U' */
	vec modulus;        /* Pa, per initial volume */
};

VECFN vec vec_exp(vec s)
{
	vec e = EXP_SERIES(s);
	if (mask_all(mask_above(vec_set(SERIES_MOST), vec_magnitude(s))))
		return e;
	for (int l = 0; l < VECTOR_WIDTH; l++)
		e[l] = exp_by_series(s[l]);
	return e;
}

VECFN struct whole respond(const struct rankine_model *m, const vec F[4], vec J, vec ij, vec warming)
{
	struct whole t;
	vec ln_j = vec_log_by_ratio(J), iso = vec_exp(-2.0 / 3.0 * ln_j);
	vec bxx = iso * (F[0] * F[0] + F[1] * F[1]), byy = iso * (F[2] * F[2] + F[3] * F[3]);
	vec bxy = iso * (F[0] * F[2] + F[1] * F[3]), trace = bxx + byy + iso, third = trace * (1.0 / 3.0);
	vec heat = m->coupling * m->K * warming, volumetric = m->K * ln_j - heat * (1.0 - ln_j) * ij;
	t.xx = volumetric + m->G * (bxx - third), t.yy = volumetric + m->G * (byy - third);
	t.zz = volumetric + m->G * (iso - third), t.xy = m->G * bxy;
	vec d = 0.5 * (t.xx - t.yy), half = 0.5 * (bxx - byy), b_radius = vec_sqrt(half * half + bxy * bxy);
	t.mean = 0.5 * (t.xx + t.yy), t.radius = vec_sqrt(d * d + t.xy * t.xy);
	t.slope = m->K * ln_j * ij;
	t.psi = 0.5 * m->K * ln_j * ln_j + 0.5 * m->G * (trace - 3.0) - m->coupling * warming * t.slope;
	/* acoustic tensor along the largest stretch or across it; second derivatives of U and W along a (x) n */
	vec most = 0.5 * (bxx + byy) + b_radius, least = 0.5 * (bxx + byy) - b_radius;
	vec along = 5.0 / 9.0 * trace - least * (1.0 / 3.0), bulk = m->K * (1.0 - ln_j) + 3.0 * vec_magnitude(heat);
	t.modulus = vec_max(bulk, vec_set(0.0)) + m->G * vec_max(along, most);
	return t;
}

/* The damage of this step of one lane, whose largest principal stress is `most`, and the band's width at its beginning.
 */
static void advance_damage(const struct rankine_model *m, struct rankine_state *s, double most, double d, double radius)
{
	if (most <= s->R)
		return;
	if (s->began == 0.0) {
		/* the normal of the crack, by half the angle of the largest principal stress */
		double c2 = radius > 0.0 ? d / radius : 1.0;
		s->began = 1.0;
		if (m->projected)
			s->softening = rankine_softening(
				m, s->strength,
				rankine_band_width(m, sqrt(0.5 * fmax(1.0 + c2, 0.0)), sqrt(0.5 * fmax(1.0 - c2, 0.0))));
	}
	s->R = most;
	double damage =
		most < s->strength * (1.0 + 1.0 / s->softening) ? (1.0 + s->softening) * (1.0 - s->strength / most) : 1.0;
	if (damage > s->damage)
		s->damage = damage;
}

/* tau of the damaged material over J, only what pulls being scaled; returns the part of psi0 that damage takes. */
VECFN vec scale_tension(const struct whole *t, vec ij, vec damage, vec stress[4])
{
	const vec none = vec_set(0.0), one = vec_set(1.0);
	vec first = t->mean + t->radius, second = t->mean - t->radius;
	vec a = vec_select(mask_above(first, none), 1.0 - damage, one);
	vec b = vec_select(mask_above(second, none), 1.0 - damage, one);
	vec mean = 0.5 * (a * first + b * second);
	vec ratio = vec_where(mask_above(t->radius, none), 0.5 * (a * first - b * second) / t->radius);
	vec d = 0.5 * (t->xx - t->yy);
	stress[0] = (mean + ratio * d) * ij, stress[1] = (mean - ratio * d) * ij;
	stress[2] = vec_select(mask_above(t->zz, none), 1.0 - damage, one) * t->zz * ij, stress[3] = ratio * t->xy * ij;
	vec pull = vec_where(mask_above(first, none), first * first) +
			   vec_where(mask_above(second, none), second * second) + vec_where(mask_above(t->zz, none), t->zz * t->zz);
	vec all = first * first + second * second + t->zz * t->zz;
	return vec_select(mask_above(all, none), pull / all, one);
}

/* One vector. */
VECFN void rankine_members(const struct law *law, struct law_batch *batch, double dt, struct members *members)
{
	const struct rankine_model *m = law->model;
	struct rankine_state *states = (struct rankine_state *)law->states;
	vec F[4], a[4], b[4], c[4], stress[4], dT = vec_set(0.0), heat = dT;
	vec_deformation(batch, members, F);
	vec J = F[0] * F[3] - F[1] * F[2], ij = 1.0 / J;
	fail(members, ~mask_above(J, vec_set(0.0)));
	vec_of_states(states, RANKINE_STATE, 0, members, a); /* warming, J, strength, R */
	vec_of_states(states, RANKINE_STATE, 4, members, b); /* softening, damage, psi, entropy */
	if (dt > 0.0)
		dT = vec_of(batch->dT, &members->points);
	vec warming = a[0] + dT, before = b[1];
	struct whole t = respond(m, F, J, ij, warming);
	vec most = vec_max(t.mean + t.radius, t.zz) * ij, d = 0.5 * (t.xx - t.yy);
	if (mask_any(mask_above(most, a[3]))) {
		for (int l = 0; l < members->n; l++)
			if (!(members->failed >> l & 1u))
				advance_damage(m, &states[members->slots.at[l]], most[l], d[l], t.radius[l]);
		vec_of_states(states, RANKINE_STATE, 0, members, a);
		vec_of_states(states, RANKINE_STATE, 4, members, b);
	}
	vec_of_states(states, RANKINE_STATE, 8, members, c); /* elastic, fracture, expansion, began */
	vec damage = b[1], left = 1.0 - damage, share = vec_set(1.0), of_all = left * ij;
	if (m->unilateral)
		share = scale_tension(&t, ij, damage, stress);
	else
		stress[0] = of_all * t.xx, stress[1] = of_all * t.yy, stress[2] = of_all * t.zz, stress[3] = of_all * t.xy;
	vec psi = share * t.psi, entropy = m->coupling * (1.0 - share * damage) * t.slope;
	vec taken = 0.5 * (b[2] + psi) * (damage - before);
	if (dt > 0.0)
		heat = (m->heat_share * taken - (vec_of(batch->T, &members->points) - 0.5 * dT) * (entropy - b[3])) * ij / dt;
	c[0] = t.psi - damage * psi;
	c[1] += taken;
	c[2] -= 0.5 * (b[3] + entropy) * dT; /* the mean of before and after: exact along a straight path */
	a[0] = warming, a[1] = J, b[2] = psi, b[3] = entropy;
	put_states(states, RANKINE_STATE, 0, members, a);
	put_states(states, RANKINE_STATE, 4, members, b);
	put_states(states, RANKINE_STATE, 8, members, c);
	/* a broken point still has to be held when it is pressed */
	vec modulus = t.modulus * ij;
	if (!m->unilateral)
		modulus = left * t.modulus * ij;
	put_response(batch, members, stress, modulus, heat);
	if (batch->damage)
		put_numbers(batch->damage, members, damage);
}

static int rankine(const struct law *law, struct law_batch *batch, double dt, int from, int to)
{
	int failed = to;
	for (int k = from; k < to; k += VECTOR_WIDTH) {
		struct members members = members_of(batch, k, to);
		rankine_members(law, batch, dt, &members);
		int first = first_failed(&members, to);
		failed = first < failed ? first : failed;
	}
	return failed;
}
