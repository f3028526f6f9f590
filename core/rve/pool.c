#include "rve/pool.h"

#include <math.h>
#include <omp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "rve/model.h"

#ifndef TMDEMPM_GPU
const struct rve_backend *const rve_backends[] = {NULL};
#endif

enum { CPU = -1, BALANCE_EVERY = 16 };

/* Where a state's arrays are as they should be. */
enum { AT_HOST = 1, AT_DEVICE = 2 };

struct member {
	const struct rve_backend *backend;
	struct rve_device *device;
	int number;
	struct rve_device_info info;
	struct rve_task *tasks;
	int *entry; /* the batch's number of each task */
	int n;      /* tasks of this call */
};

struct rve_pool {
	const struct rve_model *model;
	unsigned char *states;
	int n;
	int n_members, with_cpu, fall_back;
	struct member members[RVE_DEVICES_MOST];
	struct rve_head *before; /* [n]: of the batch's RVEs before the call */
	int *home;               /* [n]: member that is to advance a slot, or CPU */
	int *holder;             /* [n]: member whose copy AT_DEVICE speaks of */
	unsigned char *at;       /* [n] */
	int *here;               /* entries of the batch that this processor advances */
	double cpu_share;        /* of the slots */
	double cpu_seconds, seconds; /* since the last balance: of the processor's part, of the whole call */
	long long cpu_steps, steps;
	int calls;
};

static unsigned char *state_at(const struct rve_pool *p, int slot)
{
	return p->states + (size_t)slot * (size_t)p->model->layout.bytes;
}

static struct rve_head *head_at(const struct rve_pool *p, int slot)
{
	return (struct rve_head *)(void *)state_at(p, slot);
}

/* ---- choosing ---- */

/* The backend and the number of NAME[:N]; NULL if it is no device. */
static const struct rve_backend *parse(const char *text, size_t length, int *number)
{
	const char *colon = memchr(text, ':', length);
	size_t name = colon ? (size_t)(colon - text) : length;
	*number = 0;
	for (size_t k = name + 1; k < length; k++) {
		if (text[k] < '0' || text[k] > '9' || *number > 99)
			return NULL;
		*number = *number * 10 + text[k] - '0';
	}
	if (colon && name + 1 == length)
		return NULL;
	for (int b = 0; rve_backends[b]; b++)
		if (strlen(rve_backends[b]->name) == name && !memcmp(rve_backends[b]->name, text, name))
			return rve_backends[b];
	return NULL;
}

int rve_devices_check(const char *devices)
{
	int number, n = 0;
	if (!strcmp(devices, "auto") || !strcmp(devices, "cpu"))
		return STATUS_OK;
	for (const char *at = devices;; at++) {
		size_t length = strcspn(at, ",");
		if (!(length == 3 && !memcmp(at, "cpu", 3)) && !parse(at, length, &number))
			return error_set(STATUS_INPUT,
							 "--device %s: expected auto, cpu, cuda, opencl or opencl:N, several separated by commas%s",
							 devices, rve_backends[0] ? "" : " (this build has no devices: build with -DTMDEMPM_GPU=ON)");
		if (++n > RVE_DEVICES_MOST)
			return error_set(STATUS_INPUT, "--device: more than %d devices", RVE_DEVICES_MOST);
		at += length;
		if (!*at)
			return STATUS_OK;
	}
}

static void say(char *note, size_t bytes, const char *format, ...) __attribute__((format(printf, 3, 4)));
static void say(char *note, size_t bytes, const char *format, ...)
{
	size_t used = strlen(note);
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(note + used, bytes - used, format, arguments);
	va_end(arguments);
}

/* Whether `auto` may take this device; if not, `note` says why. */
static int is_fit(const struct rve_backend *backend, int number, const struct rve_device_info *device, char *note,
				  size_t bytes)
{
	const int fit = device->is_gpu && !device->unfit[0];
	if (!fit)
		say(note, bytes, "%s:%d %s: %s; ", backend->name, number, device->name,
			device->unfit[0] ? device->unfit : "no GPU");
	return fit;
}

/* Whether there is a device that `auto` may take; if not, `note` says why. */
static int find_any(char *note, size_t bytes)
{
	struct rve_device_info devices[RVE_DEVICES_MOST];
	for (int b = 0; rve_backends[b]; b++) {
		char why[256] = "";
		const int n = rve_backends[b]->list(devices, RVE_DEVICES_MOST, why, sizeof why);
		for (int k = 0; k < n; k++)
			if (is_fit(rve_backends[b], k, &devices[k], note, bytes))
				return 1;
		if (n == 0)
			say(note, bytes, "%s: %s; ", rve_backends[b]->name, why);
	}
	return 0;
}

int rve_devices_any(const char *devices)
{
	char note[512] = "";
	return strcmp(devices, "auto") != 0 ? strcmp(devices, "cpu") != 0 : find_any(note, sizeof note);
}

static int open_member(struct rve_pool *p, const struct rve_backend *backend, int number, int threads)
{
	const struct rve_model *model = p->model;
	const real *tables[model->n_variants];
	for (int v = 0; v < model->n_variants; v++)
		tables[v] = model->variants[v].table;
	const struct rve_device_setup setup = {&model->layout, &model->constants, model->n_variants, tables, p->n, threads};
	struct member *m = &p->members[p->n_members];
	struct rve_device_info devices[RVE_DEVICES_MOST];
	char why[256];
	*m = (struct member){.backend = backend, .number = number};
	CHECK(backend->open(&m->device, number, &setup));
	if (number < backend->list(devices, RVE_DEVICES_MOST, why, sizeof why))
		m->info = devices[number];
	p->n_members++;
	m->tasks = calloc((size_t)p->n + 1, sizeof *m->tasks);
	m->entry = calloc((size_t)p->n + 1, sizeof *m->entry);
	return m->tasks && m->entry ? STATUS_OK : error_set(STATUS_RESOURCE, "out of memory for %d RVEs", p->n);
}

/* The first GPU that can be opened. */
static void open_any(struct rve_pool *p, int threads, char *note, size_t bytes)
{
	struct rve_device_info devices[RVE_DEVICES_MOST];
	p->fall_back = 1;
	for (int b = 0; rve_backends[b] && p->n_members == 0; b++) {
		char why[256] = "";
		int n = rve_backends[b]->list(devices, RVE_DEVICES_MOST, why, sizeof why);
		for (int k = 0; k < n && p->n_members == 0; k++) {
			if (is_fit(rve_backends[b], k, &devices[k], note, bytes) &&
				open_member(p, rve_backends[b], k, threads) != STATUS_OK)
				say(note, bytes, "%s; ", error_message());
		}
		if (n == 0)
			say(note, bytes, "%s: %s; ", rve_backends[b]->name, why);
	}
}

static int open_members(struct rve_pool *p, const char *devices, int threads)
{
	for (const char *at = devices;; at++) {
		size_t length = strcspn(at, ",");
		int number;
		const struct rve_backend *backend = parse(at, length, &number);
		if (backend)
			CHECK(open_member(p, backend, number, threads));
		else
			p->with_cpu = 1;
		at += length;
		if (!*at)
			return STATUS_OK;
	}
}

/* Slots in a row to each member, the processor's first. */
static void deal_out(struct rve_pool *p)
{
	int cpu = p->with_cpu ? (int)(p->cpu_share * p->n + 0.5) : 0, rest = p->n - cpu;
	for (int slot = 0; slot < p->n; slot++)
		p->home[slot] =
			p->n_members == 0 || slot < cpu ? CPU : (int)((long long)(slot - cpu) * p->n_members / (rest > 0 ? rest : 1));
}

static void name_members(const struct rve_pool *p, char *note, size_t bytes)
{
	for (int m = 0; m < p->n_members; m++)
		say(note, bytes, "%s%s:%d %s (%s)", m ? ", " : "", p->members[m].backend->name, p->members[m].number,
			p->members[m].info.name, p->members[m].info.driver);
	say(note, bytes, "%s", p->n_members == 0 ? "cpu" : p->with_cpu ? ", cpu" : "");
}

int rve_pool_create(struct rve_pool **pool, const struct rve_model *model, unsigned char *states, int n,
					const char *devices, int threads, char *note, size_t note_bytes)
{
	size_t size = (size_t)n + 1;
	*pool = NULL;
	note[0] = '\0';
	CHECK(rve_devices_check(devices));
	if (model->params.quiet_change > 0.0) { /* it decides from call to call whether discs move at all */
		if (strcmp(devices, "auto") != 0 && strcmp(devices, "cpu") != 0)
			return error_set(STATUS_INPUT, "--device %s: economy.quiet is the processor's only: leave out one of them",
							 devices);
		return say(note, note_bytes, "cpu (economy.quiet is on)"), STATUS_OK;
	}
	if (model->packed && strcmp(devices, "auto") != 0)
		return error_set(STATUS_INPUT,
						 "--device %s: devices compute what the path \"serial\" does, these RVEs are of the path \"%s\": leave out "
						 "rve.path or the device; a restart takes --allow-path-change",
						 devices, rve_path_name(model->params.path));
	if (model->packed && !find_any(note, note_bytes))
		return say(note, note_bytes, "cpu"), STATUS_OK;
	if (model->packed) {
		note[0] = '\0';
		return say(note, note_bytes, "cpu (devices have no path \"%s\")", rve_path_name(model->params.path)), STATUS_OK;
	}
	struct rve_pool *p = calloc(1, sizeof *p);
	if (!p)
		return error_set(STATUS_RESOURCE, "out of memory for %d RVEs", n);
	*p = (struct rve_pool){.model = model, .states = states, .n = n, .cpu_share = 0.2};
	p->before = calloc(size, sizeof *p->before), p->home = calloc(size, sizeof *p->home);
	p->holder = calloc(size, sizeof *p->holder), p->at = calloc(size, 1), p->here = calloc(size, sizeof *p->here);
	int status = STATUS_OK;
	if (!p->before || !p->home || !p->holder || !p->at || !p->here)
		status = error_set(STATUS_RESOURCE, "out of memory for %d RVEs", n);
	else if (!strcmp(devices, "auto"))
		open_any(p, threads, note, note_bytes);
	else
		status = open_members(p, devices, threads);
	if (status == STATUS_OK && p->n_members > 0) {
		deal_out(p);
		rve_pool_touched(p, -1);
		*pool = p;
	}
	if (status == STATUS_OK)
		name_members(p, note, note_bytes);
	if (!*pool)
		rve_pool_free(p);
	return status;
}

static void leave(struct member *m)
{
	if (m->device)
		m->backend->close(m->device);
	m->device = NULL;
}

void rve_pool_free(struct rve_pool *p)
{
	if (!p)
		return;
	for (int m = 0; m < p->n_members; m++) {
		leave(&p->members[m]);
		free(p->members[m].tasks);
		free(p->members[m].entry);
	}
	free(p->before);
	free(p->home);
	free(p->holder);
	free(p->at);
	free(p->here);
	free(p);
}

/* ---- copies ---- */

int rve_pool_fetch(struct rve_pool *p, int slot)
{
	if (!p)
		return STATUS_OK;
	for (int k = slot < 0 ? 0 : slot; k < (slot < 0 ? p->n : slot + 1); k++) {
		if (p->at[k] & AT_HOST)
			continue;
		struct rve_head head = *head_at(p, k); /* what was decided here since is only here */
		const struct member *m = &p->members[p->holder[k]];
		if (!m->device || m->backend->get(m->device, k, state_at(p, k)) != STATUS_OK)
			return m->device ? error_context(STATUS_RESOURCE, "RVE %d", k)
							 : error_set(STATUS_RESOURCE, "RVE %d was on a device that is lost", k);
		*head_at(p, k) = head;
		p->at[k] |= AT_HOST;
	}
	return STATUS_OK;
}

void rve_pool_touched(struct rve_pool *p, int slot)
{
	for (int k = slot < 0 ? 0 : slot; p && k < (slot < 0 ? p->n : slot + 1); k++)
		p->at[k] = AT_HOST;
}

static int send(struct rve_pool *p, int slot, int member)
{
	const struct member *m = &p->members[member];
	if ((p->at[slot] & AT_DEVICE) && p->holder[slot] == member)
		return STATUS_OK;
	CHECK(rve_pool_fetch(p, slot));
	CHECK(m->backend->put(m->device, slot, state_at(p, slot)));
	p->holder[slot] = member;
	p->at[slot] = AT_HOST | AT_DEVICE;
	return STATUS_OK;
}

/* ---- one call ---- */

struct call {
	struct rve_batch *batch;
	int n_here;
	struct rve_outcome worst;
};

static int slot_of(const struct rve_batch *batch, int k) { return batch->slot ? batch->slot[k] : k; }

/* Sorts the batch: to the devices what they can do, the rest to this processor. */
static int sort_out(struct rve_pool *p, struct call *call)
{
	call->n_here = 0;
	for (int m = 0; m < p->n_members; m++)
		p->members[m].n = 0;
	for (int k = 0; k < call->batch->n; k++) {
		int slot = slot_of(call->batch, k), home = p->home[slot];
		struct rve_motion motion = rve_batch_motion(call->batch, k);
		p->before[k] = *head_at(p, slot);
		if (home != CPU && rve_is_plain(p->model, head_at(p, slot), &motion)) {
			CHECK(send(p, slot, home));
			struct member *m = &p->members[home];
			m->entry[m->n++] = k;
		} else {
			CHECK(rve_pool_fetch(p, slot));
			p->here[call->n_here++] = k;
		}
	}
	return STATUS_OK;
}

static int submit(struct rve_pool *p, struct call *call, struct member *m)
{
	for (int t = 0; t < m->n; t++) {
		int k = m->entry[t], slot = slot_of(call->batch, k);
		struct rve_motion motion = rve_batch_motion(call->batch, k);
		struct rve_task *task = &m->tasks[t];
		task->head = p->before[k];
		task->call = rve_begin(p->model, &task->head, &motion);
		task->place = slot;
		task->status = KERNEL_OK;
	}
	return m->backend->submit(m->device, m->n, m->tasks);
}

static void note_failure(struct call *call, int k, struct rve_outcome outcome)
{
	if (outcome.kind != OUTCOME_OK && (call->batch->failed < 0 || k < call->batch->failed)) {
		call->batch->failed = k;
		call->worst = outcome;
	}
}

static void advance_here(struct rve_pool *p, struct call *call)
{
	const struct rve_model *model = p->model;
	int threads = omp_get_max_threads() < model->n_threads ? omp_get_max_threads() : model->n_threads;
	threads = threads < call->n_here ? threads : call->n_here > 0 ? call->n_here : 1;
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
	for (int h = 0; h < call->n_here; h++) {
		int k = p->here[h], slot = slot_of(call->batch, k);
		struct rve_outcome outcome = rve_advance_one(model, state_at(p, slot), rve_scratch(model, omp_get_thread_num()),
													 rve_batch_motion(call->batch, k));
		p->at[slot] = AT_HOST;
		rve_answer(model, call->batch, k, head_at(p, slot), p->before[k].ledger[LEDGER_FRICTION]);
#pragma omp critical(rve_failure)
		note_failure(call, k, outcome);
	}
}

static void take_back(struct rve_pool *p, struct call *call, const struct member *m)
{
	for (int t = 0; t < m->n; t++) {
		int k = m->entry[t], slot = slot_of(call->batch, k);
		struct rve_head *head = head_at(p, slot);
		*head = m->tasks[t].head;
		p->at[slot] = AT_DEVICE;
		note_failure(call, k, rve_end(p->model, head, m->tasks[t].status));
		rve_answer(p->model, call->batch, k, head, p->before[k].ledger[LEDGER_FRICTION]);
	}
}

/* A device that does not answer.  If it only did not begin, its states are as they were and may still be had; then the
 * processor goes on with them, where the user left the choice to the program. */
static int lost(struct rve_pool *p, struct call *call, struct member *m, int begun)
{
	char message[1024];
	snprintf(message, sizeof message, "%s", error_message());
	int status = begun || !p->fall_back ? STATUS_RESOURCE : STATUS_OK;
	for (int slot = 0; slot < p->n && status == STATUS_OK; slot++)
		if (p->holder[slot] == m - p->members)
			status = rve_pool_fetch(p, slot);
	if (status != STATUS_OK)
		return error_set(STATUS_RESOURCE,
						 "%s; what it held is lost with it: go on from the last checkpoint (--restart "
						 "FOLDER/checkpoint.h5), with --device cpu if it does not come back",
						 message);
	fprintf(stderr, "warning: %s; the RVEs go on on the processor, with the same bits\n", message);
	for (int t = 0; t < m->n; t++)
		p->here[call->n_here++] = m->entry[t];
	for (int slot = 0; slot < p->n; slot++) {
		p->home[slot] = p->home[slot] == m - p->members ? CPU : p->home[slot];
		p->at[slot] = p->holder[slot] == m - p->members ? AT_HOST : p->at[slot];
	}
	m->n = 0;
	leave(m);
	return STATUS_OK;
}

/* Shares after the measured rates.  Where a device was done before the processor, its rate is known from below only:
 * then the processor's share shrinks a little until the device is the later one. */
static void balance(struct rve_pool *p)
{
	if (!p->with_cpu || ++p->calls % BALANCE_EVERY)
		return;
	double mine = p->cpu_seconds, all = p->seconds, steps = (double)(p->steps - p->cpu_steps);
	if (mine > 0.0 && steps > 0.0) {
		double cpu = (double)p->cpu_steps / mine, devices = steps / all;
		p->cpu_share = mine > 0.98 * all ? 0.9 * p->cpu_share : cpu / (cpu + devices);
		p->cpu_share = fmin(fmax(p->cpu_share, 0.005), 0.995);
		deal_out(p);
	}
	p->cpu_seconds = p->seconds = 0.0;
	p->cpu_steps = p->steps = 0;
}

static void count(struct rve_pool *p, const struct call *call, double begun, double here)
{
	for (int k = 0; k < call->batch->n; k++)
		p->steps += head_at(p, slot_of(call->batch, k))->sub_steps;
	for (int h = 0; h < call->n_here; h++)
		p->cpu_steps += head_at(p, slot_of(call->batch, p->here[h]))->sub_steps;
	p->cpu_seconds += here;
	p->seconds += omp_get_wtime() - begun;
}

int rve_pool_advance(struct rve_pool *p, struct rve_batch *batch)
{
	struct call call = {.batch = batch};
	batch->failed = -1;
	CHECK(sort_out(p, &call));
	double begun = omp_get_wtime();
	for (int m = 0; m < p->n_members; m++)
		if (p->members[m].device && submit(p, &call, &p->members[m]) != STATUS_OK)
			CHECK(lost(p, &call, &p->members[m], 0));
	double here = omp_get_wtime();
	advance_here(p, &call);
	here = omp_get_wtime() - here;
	for (int m = 0; m < p->n_members; m++) {
		struct member *member = &p->members[m];
		if (member->device && member->backend->wait(member->device, member->n, member->tasks) != STATUS_OK)
			CHECK(lost(p, &call, member, 1));
		take_back(p, &call, member);
	}
	count(p, &call, begun, here);
	balance(p);
	if (batch->failed < 0)
		return STATUS_OK;
	int k = batch->failed;
	return rve_report_failure(&p->model->params, batch->number ? batch->number[k] : k, call.worst);
}

void rve_pool_shares(const struct rve_pool *p, char *words, size_t bytes)
{
	int here = p->n;
	words[0] = '\0';
	for (int m = 0; m < p->n_members; m++) {
		int n = 0;
		for (int slot = 0; slot < p->n; slot++)
			n += p->home[slot] == m;
		here -= n;
		say(words, bytes, "%s:%d %s %d, ", p->members[m].backend->name, p->members[m].number, p->members[m].info.name, n);
	}
	say(words, bytes, "cpu %d", here);
}
