/* Heat flow q = -k grad T of points and their sources, to their nodes.  Included by kernel_text.h only. */

/* What a chunk's points bring to their nodes, W. */
struct flows {
	double T[SHAPE_MAX_NODES][SHAPE_CHUNK];  /* K, of the nodes; then what they get */
	double gx[SHAPE_CHUNK], gy[SHAPE_CHUNK]; /* K/m */
	double k[3][SHAPE_CHUNK];                /* W/(m K), conductivity xx yy xy */
	double source[SHAPE_CHUNK];              /* W */
} ALIGNED;

INLINE void find_flows(const struct mpm *mpm, const struct shape_lists *lists, const int *chunk, int n, int nodes,
					   struct flows *flows)
{
	const struct particles *p = &mpm->p;
	for (int a = 0; a < nodes; a++)
		for (int k = 0; k < n; k++)
			flows->T[a][k] = mpm->grid.T_new[lists->node[a][k]];
	for (int k = 0; k < n; k += VECTOR_WIDTH) {
		const struct lanes lanes = lanes_of(n, chunk, k);
		vec F[4], gx = vec_set(0.0), gy = gx;
		vec_of4((const double(*)[4])p->F, &lanes, F);
		for (int a = 0; a < nodes; a++) {
			gx += vec_load(&lists->grad_x[a][k]) * vec_load(&flows->T[a][k]);
			gy += vec_load(&lists->grad_y[a][k]) * vec_load(&flows->T[a][k]);
		}
		vec volume = (F[0] * F[3] - F[1] * F[2]) * vec_of(p->volume0, &lanes);
		vec xx = vec_load(&flows->k[0][k]), yy = vec_load(&flows->k[1][k]), xy = vec_load(&flows->k[2][k]);
		vec qx = -volume * (xx * gx + xy * gy), qy = -volume * (xy * gx + yy * gy);
		vec source = vec_load(&flows->source[k]);
		vec_store(&flows->gx[k], gx);
		vec_store(&flows->gy[k], gy);
		for (int a = 0; a < nodes; a++)
			vec_store(&flows->T[a][k], vec_load(&lists->grad_x[a][k]) * qx + vec_load(&lists->grad_y[a][k]) * qy +
										   vec_load(&lists->weight[a][k]) * source);
	}
}

/* The sources of a chunk's points, W, and their conductivities. */
INLINE void begin_flows(const struct mpm *mpm, const struct mpm_work *w, const struct shape_lists *lists,
						const int *chunk, int n, int nodes, double dt, struct stripe_sum *sum, struct flows *flows)
{
	const struct particles *p = &mpm->p;
	for (int k = 0; k < n; k++) {
		double conductivity[3];
		mpm_point_conductivity(mpm, chunk[k], conductivity);
		for (int c = 0; c < 3; c++)
			flows->k[c][k] = conductivity[c];
		flows->source[k] = p->heat_pending[chunk[k]] / w->thermal_dt;
		if (!w->n_point_heats)
			continue;
		double T = 0.0;
		for (int a = 0; a < nodes; a++)
			T += lists->weight[a][k] * mpm->grid.T_new[lists->node[a][k]];
		double flow = thermal_boundary(w, p->x[chunk[k]], T) * mat2_determinant(p->F[chunk[k]]) * p->volume0[chunk[k]];
		sum->heat_in += flow > 0.0 ? flow * dt : 0.0;
		sum->heat_out -= flow < 0.0 ? flow * dt : 0.0;
		flows->source[k] += flow;
	}
	for (int c = 0; c < 3; c++) /* as the lists, to the end of the last vector */
		for (int k = n; k % VECTOR_WIDTH; k++)
			flows->k[c][k] = flows->source[k] = 0.0;
	for (int a = 0; a < nodes; a++)
		for (int k = n; k % VECTOR_WIDTH; k++)
			flows->T[a][k] = 0.0;
}

INLINE void flow_chunk(struct mpm *mpm, struct mpm_work *w, const struct shape_lists *lists, const int *chunk, int n,
					   int nodes, double dt, bool first_pass, bool last_pass, struct stripe_sum *sum)
{
	struct particles *p = &mpm->p;
	struct flows flows;
	begin_flows(mpm, w, lists, chunk, n, nodes, dt, sum, &flows);
	find_flows(mpm, lists, chunk, n, nodes, &flows);
	for (int k = 0; k < n; k++)
		for (int a = 0; a < nodes; a++)
			w->sums[lists->node[a][k]].flow += flows.T[a][k];
	for (int k = 0; k < n && first_pass && w->imposes_T; k++)
		thermal_lift(mpm, w, lists, k, chunk[k], flows.gx[k], flows.gy[k]);
	for (int k = 0; k < n && last_pass; k++) {
		sum->heat_given += p->heat_pending[chunk[k]];
		p->heat_friction_sum[chunk[k]] += p->heat_pending[chunk[k]] / p->volume0[chunk[k]];
		p->heat_pending[chunk[k]] = 0.0;
	}
}

INLINE void flow_stripe(struct mpm *mpm, struct mpm_work *w, int stripe, int nodes, double dt, bool first_pass,
						bool last_pass)
{
	struct shape_lists lists;
	int first, last;
	mpm_stripe_points(w, stripe, &first, &last);
	for (int i = first; i < last; i += SHAPE_CHUNK) {
		const int *chunk = w->order + i, n = last - i < SHAPE_CHUNK ? last - i : SHAPE_CHUNK;
		mpm_lists(mpm, n, chunk, &lists);
		if (nodes == SHAPE_MAX_NODES && lists.nodes == 9)
			flow_chunk(mpm, w, &lists, chunk, n, 9, dt, first_pass, last_pass, &w->stripe_sums[stripe]);
		else
			flow_chunk(mpm, w, &lists, chunk, n, nodes, dt, first_pass, last_pass, &w->stripe_sums[stripe]);
	}
}

static void flow_stripe_any(struct mpm *mpm, struct mpm_work *w, int stripe, double dt, bool first_pass, bool last_pass)
{
	if (mpm->shape->max_nodes == 9)
		flow_stripe(mpm, w, stripe, 9, dt, first_pass, last_pass);
	else if (mpm->shape->max_nodes == 4)
		flow_stripe(mpm, w, stripe, 4, dt, first_pass, last_pass);
	else
		flow_stripe(mpm, w, stripe, SHAPE_MAX_NODES, dt, first_pass, last_pass);
}
