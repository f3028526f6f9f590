#include "study/study.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/error.h"
#include "run/folder.h"
#include "study/exact_reference.h"
#include "study/job.h"
#include "study/report.h"
#include "version.h"

enum { NO_MATPLOTLIB = 77 }; /* exit code of study_chart.py */

/* ---- charts ---- */

/* The exit code of one attempt with one interpreter; -1 if it cannot be started. */
static int chart_try(const char *python, const char *folder)
{
	fflush(NULL);
	pid_t pid = fork();
	if (pid == 0) {
		execlp(python, python, TMDEMPM_PIPELINES "/study_chart.py", folder, (char *)NULL);
		_exit(127);
	}
	int status;
	if (pid < 0 || waitpid(pid, &status, 0) != pid || !WIFEXITED(status))
		return -1;
	return WEXITSTATUS(status);
}

/* Charts are welcome, not needed: the numbers are written. */
static void chart(const char *folder)
{
	static const char *const pythons[] = {"python3", "/usr/bin/python3"}; /* the second has the system's packages */
	int code = -1;
	for (size_t k = 0; k < sizeof pythons / sizeof *pythons && code != 0; k++) {
		code = chart_try(pythons[k], folder);
		if (code != NO_MATPLOTLIB && code != 127)
			break;
	}
	if (code == NO_MATPLOTLIB || code == 127)
		fprintf(stderr,
				"tmdempm study: no charts: install python3-matplotlib (apt-get install python3-matplotlib), then run "
				"pipelines/study_chart.py %s\n",
				folder);
	else if (code != 0)
		fprintf(stderr, "tmdempm study: the charts failed; pipelines/study_chart.py %s draws them again\n", folder);
}

/* ---- one study ---- */

/* Mistakes in names of solutions and fields are told before the first run. */
static int check_exact(const struct plan *plan)
{
	const struct study *study = plan->study;
	for (int i = 0; i < plan->n && study->reference.kind == STUDY_EXACT; i++) {
		struct exact_reference exact;
		const double X[2] = {0.0, 0.0};
		double unused;
		CHECK(exact_reference_get(&exact, study, plan->combinations[i].choice));
		for (int k = 0; k < study->n_norms; k++)
			if (study->norms[k].exact[0]) {
				int status = exact_reference_value(&exact, study->norms[k].exact, X, 1.0, &unused);
				if (status != STATUS_OK)
					return error_context(status, "%s: norms.%s", study->file, study->norms[k].name);
			}
	}
	return STATUS_OK;
}

/* A setting that the scene refuses is a mistake in the study, or, where it is limits that are studied, a guard. */
static int name_runs(struct plan *plan, const char *folder)
{
	int refused = 0, status = STATUS_OK;
	for (int k = 0; k < plan->n; k++) {
		struct combination *c = &plan->combinations[k];
		int one = job_name(plan->study, c, folder);
		if (one == STATUS_OK)
			continue;
		if (one != STATUS_INPUT || !plan->study->stability)
			return one;
		c->result.outcome = OUTCOME_REFUSED;
		snprintf(c->result.reason, sizeof c->result.reason, "%s", error_message());
		status = one, refused++;
	}
	return refused == plan->n ? status : STATUS_OK;
}

static void print_plan(const struct plan *plan)
{
	for (int k = 0; k < plan->n; k++)
		printf("%s%s  %s\n", plan->combinations[k].name, plan->combinations[k].asked ? "" : " (reference)",
			   plan->combinations[k].hash);
}

static int write_results(struct plan *plan, const char *folder, const struct study_options *options)
{
	CHECK(norms_evaluate(plan));
	CHECK(report_write_csv(plan, folder));
	CHECK(report_write_summary(plan, folder));
	CHECK(report_write_json(plan, folder));
	printf("%s/study.csv\n", folder);
	if (!options->no_charts)
		chart(folder);
	return report_gates(plan);
}

static int run_plan(struct plan *plan, const char *folder, const struct study_options *options)
{
	char moved[FILE_PATH];
	int lock;
	CHECK(check_exact(plan));
	CHECK(name_runs(plan, folder));
	if (options->list) {
		print_plan(plan);
		return STATUS_OK;
	}
	CHECK(folder_make(folder, false, moved, &lock));
	file_sweep(folder);
	int status = schedule_run(plan, options);
	if (status == STATUS_OK)
		status = write_results(plan, folder, options);
	close(lock);
	return status;
}

/* DIR/NAME, NAME = the file's without its end. */
static int study_folder(char folder[FILE_PATH], const char *out, const char *file)
{
	char name[FILE_PATH];
	const char *base = strrchr(file, '/');
	CHECK(file_join(name, "", base ? base + 1 : file));
	char *end = strrchr(name, '.');
	if (end && end != name)
		*end = '\0';
	return file_join(folder, out, name);
}

static int study_one(const char *file, const struct study_options *options)
{
	struct study *study;
	struct plan plan;
	char folder[FILE_PATH];
	CHECK(study_folder(folder, options->out, file));
	CHECK(study_load(&study, file, options->n_sets, options->sets, stderr));
	int status = plan_create(&plan, study);
	if (status == STATUS_OK) {
		status = run_plan(&plan, folder, options);
		plan_free(&plan);
	}
	study_free(study);
	return status;
}

/* A missed gate does not keep the other studies from being run; anything else does. */
int study_run(int n_files, char *const *files, const struct study_options *options)
{
	char first[1024] = "";
	for (int k = 0; k < n_files; k++) {
		int status = study_one(files[k], options);
		if (status == STATUS_GUARD && !first[0])
			snprintf(first, sizeof first, "%s", error_message());
		else if (status != STATUS_OK && status != STATUS_GUARD)
			return status;
	}
	return first[0] ? error_set(STATUS_GUARD, "%s", first) : STATUS_OK;
}
