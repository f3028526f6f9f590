#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "run/run_private.h"

void run_counts(const struct run *run, struct law_counts *counts)
{
	memset(counts, 0, sizeof *counts);
	for (int l = 0; l < run->mpm->n_laws; l++) {
		const struct law *law = run->mpm->laws[l];
		struct law_counts one = {0};
		if (!law->type->counts)
			continue;
		law->type->counts(law, &one);
		counts->disc_steps += one.disc_steps;
		counts->gas += one.gas;
		counts->frozen += one.frozen;
		counts->reseeded += one.reseeded;
		counts->clamped += one.clamped;
		counts->rebuilds += one.rebuilds;
		counts->calls += one.calls;
		counts->quiet_calls += one.quiet_calls;
		counts->quiet_caught += one.quiet_caught;
		counts->quiet_error_sum += one.quiet_error_sum;
		counts->quiet_error_most = fmax(counts->quiet_error_most, one.quiet_error_most);
		counts->paced_calls += one.paced_calls;
		counts->paced_saved += one.paced_saved;
		counts->paced_error_sum += one.paced_error_sum;
		counts->paced_error_most = fmax(counts->paced_error_most, one.paced_error_most);
		counts->twin_calls += one.twin_calls;
		counts->twin_disc_steps += one.twin_disc_steps;
		counts->bonds_installed += one.bonds_installed;
		counts->bonds_intact += one.bonds_intact;
		for (size_t i = 0; i < sizeof one.inertia / sizeof *one.inertia; i++)
			counts->inertia[i] += one.inertia[i];
	}
}

/* 1234567 -> "1.23 M". */
static void progress_rate(double value, char text[32])
{
	double scaled = value >= 1e6 ? value * 1e-6 : value >= 1e3 ? value * 1e-3 : value;
	snprintf(text, 32, "%.3g %s", scaled, value >= 1e6 ? "M" : value >= 1e3 ? "k" : "");
}

static void progress_duration(double seconds, char text[32])
{
	if (!(seconds >= 0 && seconds < 1e8))
		snprintf(text, 32, "?");
	else if (seconds < 100)
		snprintf(text, 32, "%.0f s", seconds);
	else if (seconds < 3600)
		snprintf(text, 32, "%d min %02d s", (int)seconds / 60, (int)seconds % 60);
	else
		snprintf(text, 32, "%d h %02d min", (int)(seconds / 3600), (int)(seconds / 60) % 60);
}

static int progress_temperature(const struct mpm *mpm, char *text, size_t size)
{
	double low = INFINITY, high = -INFINITY;
	for (int p = 0; p < mpm->p.n; p++) {
		low = fmin(low, mpm->p.T[p]);
		high = fmax(high, mpm->p.T[p]);
	}
	return snprintf(text, size, ", T %.6g .. %.6g %s", scene_temperature_out(mpm->scene, low),
					scene_temperature_out(mpm->scene, high), scene_temperature_unit(mpm->scene));
}

static void progress_text(const struct run *run, char *text, size_t size)
{
	const struct mpm *mpm = run->mpm;
	double elapsed = clock_seconds() - run->loop_start;
	long long done = mpm->step - run->first_step, left = run->last_step - mpm->step;
	char points[32], discs[32], eta[32];
	struct law_counts counts;
	run_counts(run, &counts);
	progress_rate(elapsed > 0 ? (double)done * mpm->p.n / elapsed : 0, points);
	progress_rate(elapsed > 0 ? (double)(counts.disc_steps - run->first_disc_steps) / elapsed : 0, discs);
	progress_duration(done > 0 ? elapsed / (double)done * (double)left : INFINITY, eta);
	int n = snprintf(text, size, "step %lld/%lld, t %.5g s, dt %.3g s, %spoint-steps/s", mpm->step, run->last_step,
					 mpm->time, mpm->dt, points);
	if (counts.disc_steps > 0)
		n += snprintf(text + n, size - (size_t)n, ", %sdisc-steps/s", discs);
	n += snprintf(text + n, size - (size_t)n, ", ETA %s", eta);
	if (mpm->thermal)
		progress_temperature(mpm, text + n, size - (size_t)n);
}

void progress_update(struct run *run, bool now)
{
	double time = clock_seconds();
	if (run->log.quiet || (!now && time < run->next_progress))
		return;
	bool terminal = isatty(STDERR_FILENO);
	if (!now && !terminal && run->next_progress == 0) { /* the first line comes when there is something to say */
		run->next_progress = time + 5;
		return;
	}
	run->next_progress = time + (terminal ? 0.25 : 5);
	char text[512];
	progress_text(run, text, sizeof text);
	log_progress(&run->log, text);
}
