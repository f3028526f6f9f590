#include "rve/quiet.h"

#include <math.h>
#include <string.h>

#include "base/mat2.h"

/* rad: up to here a turn and a strain in one call are as good as one after the other */
static const double turn_most = 0.02;

static double largest(double a, double b, double c) { return fmax(fmax(fabs(a), fabs(b)), fabs(c)); }

/* Of the stress through a call, J. */
static double work_of(const struct rve_model *model, const struct rve_head *head, const double from[4],
					  const double to[4], const struct rve_motion *call)
{
	const double *L = call->L;
	double volume = mat2_determinant(head->F) * model->variants[head->variant].volume;
	double xx = 0.5 * (from[0] + to[0]), yy = 0.5 * (from[1] + to[1]), xy = 0.5 * (from[3] + to[3]);
	return volume * call->duration * (xx * L[0] + yy * L[3] + xy * (L[1] + L[2]));
}

/* What discs that grow put in, J. */
static double expansion_of(const struct rve_model *model, const struct rve_head *head, const double from[4],
						   const double to[4], const struct rve_motion *call)
{
	double volume = mat2_determinant(head->F) * model->variants[head->variant].volume;
	return -0.5 * volume * (from[0] + to[0] + from[1] + to[1]) * model->params.expansion * call->dT;
}

/* The motion with what has waited, as a gradient over the duration of the call: X = ln(exp(L dt) G). */
static void add_up(const struct rve_head *head, const struct rve_motion *call, double X[4], double G[4],
				   double *heating)
{
	const struct rve_held *held = &head->held;
	double increment[4], move[4], before[4] = {1.0, 0.0, 0.0, 1.0};
	for (int k = 0; k < 4; k++)
		increment[k] = call->L[k] * call->duration;
	if (held->calls > 0)
		memcpy(before, held->motion, sizeof before);
	mat2_exp(increment, move);
	mat2_multiply(move, before, G);
	mat2_log(G, X);
	*heating = call->dT + (held->calls > 0 ? held->heating : 0.0);
}

/* Whether the discs may go on waiting, by what has changed since they moved. */
static int may_wait(const struct rve_model *model, const struct rve_head *head, const double strain[3], double spin,
					const double change[3], double heating, const struct rve_motion *call)
{
	const struct rve_params *p = &model->params;
	double scale = rve_stress_scale(head);
	if (!(scale > p->gas_pressure) || !(head->unbalanced <= p->quiet_unbalanced) || fabs(spin) > turn_most)
		return 0;
	if (head->bonds_intact > 0 &&
		(call->T > p->bond_melting || model->constants.bond_slope * fabs(heating) > p->quiet_change))
		return 0;
	return largest(strain[0], strain[1], strain[2]) <= p->quiet_strain &&
		   largest(change[0], change[1], change[2]) <= p->quiet_change * scale;
}

/* stress <- R (held + change) R^T */
static void follow(const double base[4], double spin, const double change[3], double stress[4])
{
	double turn[4] = {0.0, spin, -spin, 0.0}, R[4], back[4];
	double S[4] = {base[0] + change[0], base[3] + change[2], base[3] + change[2], base[1] + change[1]};
	mat2_exp(turn, R);
	memcpy(back, (double[4]){R[0], R[2], R[1], R[3]}, sizeof back);
	mat2_multiply(R, S, S);
	mat2_multiply(S, back, S);
	stress[0] = S[0], stress[1] = S[3], stress[2] = 0.0, stress[3] = 0.5 * (S[1] + S[2]);
}

static void wait_on(const struct rve_model *model, struct rve_head *head, const double stress[4], const double G[4],
					double heating, const struct rve_motion *call)
{
	struct rve_held *held = &head->held;
	double work = work_of(model, head, head->stress, stress, call);
	double expansion = expansion_of(model, head, head->stress, stress, call);
	if (held->calls == 0) {
		memcpy(held->stress, head->stress, sizeof held->stress);
		held->stored = 0.0;
	}
	memcpy(held->motion, G, sizeof held->motion);
	held->heating = heating;
	held->stored += work + expansion;
	held->calls++;
	head->ledger[LEDGER_WORK] += work;
	head->ledger[LEDGER_EXPANSION] += expansion;
	head->ledger[LEDGER_ELASTIC] += work + expansion;
	memcpy(head->stress, stress, sizeof head->stress);
	head->sub_steps = 0;
	head->quiet_calls++;
}

int quiet_hold(const struct rve_model *model, struct rve_head *head, struct rve_motion *motion, struct quiet_debt *debt)
{
	debt->open = 0;
	if (!(model->params.quiet_change > 0.0) || !(motion->duration > 0.0))
		return 0;
	const double *C = head->tensor, *base = head->held.calls > 0 ? head->held.stress : head->stress;
	double X[4], G[4], heating, change[3], stress[4];
	add_up(head, motion, X, G, &heating);
	double grown = model->params.expansion * heating, spin = 0.5 * (X[1] - X[2]);
	double strain[3] = {X[0] - grown, X[3] - grown, 0.5 * (X[1] + X[2])};
	change[0] = C[0] * strain[0] + C[2] * strain[1] + 2.0 * C[4] * strain[2];
	change[1] = C[2] * strain[0] + C[1] * strain[1] + 2.0 * C[5] * strain[2];
	change[2] = C[4] * strain[0] + C[5] * strain[1] + 2.0 * C[3] * strain[2];
	follow(base, spin, change, stress);
	if (may_wait(model, head, strain, spin, change, heating, motion)) {
		wait_on(model, head, stress, G, heating, motion);
		return 1;
	}
	if (head->held.calls == 0)
		return 0;
	*debt = (struct quiet_debt){1, {0}, {0}, head->ledger[LEDGER_WORK], head->ledger[LEDGER_EXPANSION], *motion};
	memcpy(debt->stress, head->stress, sizeof debt->stress);
	memcpy(debt->predicted, stress, sizeof debt->predicted);
	for (int k = 0; k < 4; k++)
		motion->L[k] = X[k] / motion->duration;
	motion->dT = heating;
	return 0;
}

void quiet_settle(const struct rve_model *model, struct rve_head *head, const struct quiet_debt *debt)
{
	if (!debt->open)
		return;
	double worked = head->ledger[LEDGER_WORK] - debt->work, grown = head->ledger[LEDGER_EXPANSION] - debt->expansion;
	double work = work_of(model, head, debt->stress, head->stress, &debt->call);
	double expansion = expansion_of(model, head, debt->stress, head->stress, &debt->call);
	head->ledger[LEDGER_WORK] = debt->work + work;
	head->ledger[LEDGER_EXPANSION] = debt->expansion + expansion;
	head->ledger[LEDGER_DISCARDED] += work + expansion + head->held.stored - worked - grown;
	double error = largest(head->stress[0] - debt->predicted[0], head->stress[1] - debt->predicted[1],
						   head->stress[3] - debt->predicted[3]);
	error /= fmax(rve_stress_scale(head), model->params.gas_pressure);
	memset(&head->held, 0, sizeof head->held);
	head->quiet_caught++;
	head->quiet_error_sum += error;
	head->quiet_error_most = fmax(head->quiet_error_most, error);
}

void quiet_forget(struct rve_head *head)
{
	head->temperature += head->held.calls > 0 ? head->held.heating : 0.0;
	memset(&head->held, 0, sizeof head->held);
}
