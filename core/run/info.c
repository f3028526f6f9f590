/* `tmdempm info`: the tables of the program as they are, and what is missing. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/error.h"
#include "exact/exact.h"
#include "law/law.h"
#include "mpm/mpm.h"
#include "mpm/scheme.h"
#include "mpm/shape.h"
#include "run/json.h"
#include "run/machine.h"
#include "run/run.h"
#include "run/steering_command.h"
#include "run/viewer.h"
#include "rve/device.h"
#include "rve/model.h"
#include "version.h"

/* Something that the program can use, or what to do to get it. */
struct info_part {
	const char *name, *doc;
	bool there;
	const char *cure; /* when it is not there */
};

static bool info_on_path(const char *program)
{
	const char *path = getenv("PATH");
	while (path && *path) {
		char file[4096];
		int n = (int)strcspn(path, ":");
		snprintf(file, sizeof file, "%.*s/%s", n, path, program);
		if (access(file, X_OK) == 0)
			return true;
		path += n + (path[n] == ':');
	}
	return false;
}

enum { INFO_DEVICES = 3, INFO_SINKS = 5 };

static void info_devices(struct info_part parts[INFO_DEVICES])
{
	parts[0] = (struct info_part){"cpu", "OpenMP over points, nodes and RVEs, double precision", true, ""};
	parts[1] = (struct info_part){"cuda", "RVEs on an NVIDIA GPU", false, "build with -DTMDEMPM_GPU=ON"};
	parts[2] = (struct info_part){"opencl", "RVEs on an OpenCL device", false, "build with -DTMDEMPM_GPU=ON"};
	for (int b = 0; rve_backends[b]; b++) {
		static char words[INFO_DEVICES][512], cures[INFO_DEVICES][512];
		struct rve_device_info devices[RVE_DEVICES_MOST];
		struct info_part *part = strcmp(rve_backends[b]->name, "cuda") == 0 ? &parts[1] : &parts[2];
		int n = rve_backends[b]->list(devices, RVE_DEVICES_MOST, cures[b], sizeof cures[b]);
		part->doc = rve_backends[b]->doc;
		part->cure = cures[b];
		for (int k = n - 1; k >= 0; k--) { /* the first that will do is named */
			if (devices[k].unfit[0] && !part->there)
				snprintf(cures[b], sizeof cures[b], "%s: %s", devices[k].name, devices[k].unfit);
			if (devices[k].unfit[0])
				continue;
			snprintf(words[b], sizeof words[b], "%s; %s:%d is %s, %s", rve_backends[b]->doc, part->name, k,
					 devices[k].name, devices[k].driver);
			part->doc = words[b];
			part->there = true;
		}
	}
}

static void info_sinks(struct info_part parts[INFO_SINKS])
{
	bool viewer = viewer_program() != NULL, display = getenv("DISPLAY") || info_on_path("Xvfb");
	parts[0] = (struct info_part){"history", "history.csv: energies, regions, walls, probes", true, ""};
	parts[1] = (struct info_part){"snapshots", "HDF5 (run.h5, snap/) and checkpoints", true, ""};
	parts[2] = (struct info_part){"vtk", ".pvd, .vtp and .vti for ParaView", true, ""};
	parts[3] = (struct info_part){"images", "pictures by tmdempm-viewer, with or without a screen", viewer && display,
								  !viewer ? "install paraview-dev, python3-paraview, g++ and xvfb (apt-get install "
											"--no-install-recommends), then build with -DTMDEMPM_INSITU=ON"
										  : "install xvfb (apt-get install xvfb), or set DISPLAY"};
	parts[4] = (struct info_part){"catalyst", "ParaView in the run: scripts (--pipeline), a live view (--live)",
								  viewer_has_catalyst(),
								  "install python3-paraview, paraview-dev, libpython3-dev and g++ (apt-get install "
								  "--no-install-recommends), then build with -DTMDEMPM_INSITU=ON"};
}

/* ---- for people ---- */

static void info_print_parts(const char *title, const struct info_part *parts, int n)
{
	printf("%s\n", title);
	for (int i = 0; i < n; i++) {
		printf("  %-14s %s%s\n", parts[i].name, parts[i].doc, parts[i].there ? "" : "  [missing]");
		if (!parts[i].there)
			printf("  %-14s -> %s\n", "", parts[i].cure);
	}
}

static void info_print_fields(const char *owner, const struct field *fields, int n)
{
	printf("fields of %s\n", owner);
	for (int f = 0; f < n; f++)
		printf("  %-24s %-8s %d  %s\n", fields[f].name, fields[f].unit, fields[f].components, fields[f].doc);
}

static void info_print_schemes(const char *title, const struct mpm_scheme *schemes)
{
	printf("%s\n", title);
	for (int s = 0; schemes[s].name; s++)
		printf("  %-14s %s\n", schemes[s].name, schemes[s].doc);
}

static void info_print(const struct machine *machine, const struct info_part *devices, const struct info_part *sinks)
{
	printf("tmdempm %s\nbuilt    %s, %s%s\n", TMDEMPM_VERSION, TMDEMPM_COMPILER, TMDEMPM_BUILD_TYPE,
		   viewer_program() ? ", with a viewer" : ", engine alone");
	printf("machine  %s (%s), %d threads, %.1f GiB\n", machine->processor, machine->isa, machine->threads,
		   machine->memory / (1 << 30));
	printf("RVEs     compiled for x86-64 base, v3 and v4; %s runs here (the bits are the same)\n", rve_isa());
	info_print_parts("devices", devices, INFO_DEVICES);
	printf("laws\n");
	for (int l = 0; law_types[l]; l++)
		printf("  %-14s %s\n", law_types[l]->name, law_types[l]->doc);
	printf("shapes\n");
	for (int s = 0; shapes[s]; s++)
		printf("  %-14s %s\n", shapes[s]->name, shapes[s]->doc);
	info_print_schemes("transfers", mpm_transfers);
	info_print_schemes("orders", mpm_orders);
	printf("exact solutions (tmdempm exact NAME shows one)\n");
	exact_print(NULL);
	info_print_parts("sinks", sinks, INFO_SINKS);
	printf("steering (tmdempm steer DIR COMMAND...)\n%s", steering_help);
	printf("rules (inspect.NAME=RULE, rve show --rule RULE)\n");
	for (const struct rve_rule *rule = rve_rules; rule->name; rule++)
		printf("  %-16s the point with %s\n", rule->name, rule->doc);
	info_print_fields("points", particle_fields, particle_fields_count);
	for (int l = 0; law_types[l]; l++)
		if (law_types[l]->n_fields > 0)
			info_print_fields(law_types[l]->name, law_types[l]->fields, law_types[l]->n_fields);
	info_print_fields("history (energies)", mpm_ledger_fields, mpm_ledger_fields_count);
}

/* ---- for programs ---- */

static void info_json_part(struct json *json, const char *name, const char *doc)
{
	json_open(json, NULL, '{');
	json_text(json, "name", name);
	json_text(json, "doc", doc);
	json_close(json, '}');
}

static void info_json_schemes(struct json *json, const char *title, const struct mpm_scheme *schemes)
{
	json_open(json, title, '[');
	for (int s = 0; schemes[s].name; s++)
		info_json_part(json, schemes[s].name, schemes[s].doc);
	json_close(json, ']');
}

static void info_json_parts(struct json *json, const char *title, const struct info_part *parts, int n)
{
	json_open(json, title, '[');
	for (int i = 0; i < n; i++) {
		json_open(json, NULL, '{');
		json_text(json, "name", parts[i].name);
		json_text(json, "doc", parts[i].doc);
		json_bool(json, "available", parts[i].there);
		if (!parts[i].there)
			json_text(json, "install", parts[i].cure);
		json_close(json, '}');
	}
	json_close(json, ']');
}

static void info_json_fields(struct json *json, const char *owner, const struct field *fields, int n)
{
	json_open(json, owner, '[');
	for (int f = 0; f < n; f++) {
		json_open(json, NULL, '{');
		json_text(json, "name", fields[f].name);
		json_text(json, "unit", fields[f].unit);
		json_integer(json, "components", fields[f].components);
		json_text(json, "doc", fields[f].doc);
		json_close(json, '}');
	}
	json_close(json, ']');
}

static void info_json(const struct machine *machine, const struct info_part *devices, const struct info_part *sinks)
{
	struct json json = {.stream = stdout, .pretty = true};
	json_open(&json, NULL, '{');
	json_text(&json, "version", TMDEMPM_VERSION);
	json_text(&json, "compiler", TMDEMPM_COMPILER);
	json_text(&json, "build", TMDEMPM_BUILD_TYPE);
	json_text(&json, "processor", machine->processor);
	json_text(&json, "isa", machine->isa);
	json_text(&json, "rve_isa", rve_isa());
	json_integer(&json, "threads", machine->threads);
	json_number(&json, "memory", machine->memory);
	json_text(&json, "viewer", viewer_program());
	info_json_parts(&json, "devices", devices, INFO_DEVICES);
	json_open(&json, "laws", '[');
	for (int l = 0; law_types[l]; l++)
		info_json_part(&json, law_types[l]->name, law_types[l]->doc);
	json_close(&json, ']');
	json_open(&json, "shapes", '[');
	for (int s = 0; shapes[s]; s++)
		info_json_part(&json, shapes[s]->name, shapes[s]->doc);
	json_close(&json, ']');
	info_json_schemes(&json, "transfers", mpm_transfers);
	info_json_schemes(&json, "orders", mpm_orders);
	json_open(&json, "exact", '[');
	for (int s = 0; exact_solutions[s]; s++)
		info_json_part(&json, exact_solutions[s]->name, exact_solutions[s]->doc);
	json_close(&json, ']');
	info_json_parts(&json, "sinks", sinks, INFO_SINKS);
	json_open(&json, "rules", '[');
	for (const struct rve_rule *rule = rve_rules; rule->name; rule++)
		info_json_part(&json, rule->name, rule->doc);
	json_close(&json, ']');
	json_open(&json, "fields", '{');
	info_json_fields(&json, "points", particle_fields, particle_fields_count);
	for (int l = 0; law_types[l]; l++)
		info_json_fields(&json, law_types[l]->name, law_types[l]->fields, law_types[l]->n_fields);
	info_json_fields(&json, "history", mpm_ledger_fields, mpm_ledger_fields_count);
	json_close(&json, '}');
	json_close(&json, '}');
	putchar('\n');
}

int run_info(bool json)
{
	struct machine machine;
	struct info_part devices[INFO_DEVICES], sinks[INFO_SINKS];
	machine_look(&machine);
	info_devices(devices);
	info_sinks(sinks);
	(json ? info_json : info_print)(&machine, devices, sinks);
	return STATUS_OK;
}
