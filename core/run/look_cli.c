#include "run/look_cli.h"

#include <getopt.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/error.h"
#include "base/mat2.h"
#include "io/vtk.h"
#include "run/look.h"

#define WHICH                                                                                                          \
	"  --point ID       the RVE behind this point\n"                                                                   \
	"  --at x,y         behind the point that is nearest to this place now, m\n"                                       \
	"  --name NAME      of an inspection of the scene\n"                                                               \
	"  --rule RULE      "

static const char help_show[] =
	"usage: tmdempm rve show RUN_FOLDER|run.h5|checkpoint.h5|guard.h5|snap/N.h5 --point ID|--at x,y|--name NAME|--rule "
	"RULE\n"
	"                        [--time T] [--before T|FILE] [--image F.png [--field FIELD] [--map MAP] [--size WxH]]\n"
	"                        [--vtp F]\n"
	"       tmdempm rve show RVE.h5|PACKING.h5|PACKING.csv [--before FILE] [--image ...] [--vtp F]\n"
	"\n"
	"Says how an RVE of a run is, and draws it.  A checkpoint holds every RVE, snapshots the inspected ones\n"
	"(or all, with output.rve_states = \"all\").\n"
	"\n" WHICH;
static const char help_show_rest[] =
	"  --time T         s: of the run's states the nearest in time (the checkpoint, which is the last)\n"
	"  --image F.png    draws it: cell, discs, force chains, bonds, contact normals\n"
	"  --before T|FILE  beside how it was at that time of the run, or in that file\n"
	"  --field FIELD    colours of the discs: displacement (default), rotation, coordination, temperature or radius\n"
	"  --map MAP        viridis, inferno or coolwarm (for signed fields; the default of rotation)\n"
	"  --size WxH       pixels (1000x800; of a pair 1600x740)\n"
	"  --vtp F          writes F_discs.vtp and F_contacts.vtp for ParaView\n";

static const char help_extract[] =
	"usage: tmdempm rve extract RUN_FOLDER|run.h5|checkpoint.h5|snap/N.h5 --point ID|--at x,y|--name NAME|--rule RULE\n"
	"                           [--time T] --out P.h5\n"
	"\n"
	"Takes an RVE out of a run: a file with its whole state (velocities, contact history, bonds, temperature, "
	"ledgers)\n"
	"and its law's parameters, that `tmdempm rve load --packing P.h5` drives on, with the bits of the run along the\n"
	"recorded path.\n"
	"\n" WHICH;
static const char help_extract_rest[] =
	"  --time T         s: of the run's states the nearest in time (the checkpoint, which is the last)\n"
	"  --out P.h5       the RVE file\n";

struct look_options {
	const char *source, *image, *vtp, *out, *before;
	char field[FRAME_NAME], map[FRAME_NAME];
	int size[2]; /* 0 = not given */
	double time;
	struct look_choice choice;
	int n_choices;
	bool help;
};

/* ---- options ---- */

static int usage(const char *option, const char *value, const char *expected)
{
	return error_set(STATUS_INPUT, "--%s %s: expected %s", option, value, expected);
}

static int parse_number(const char *option, const char *text, double *value)
{
	char *end;
	*value = strtod(text, &end);
	return *text && !*end && isfinite(*value) ? STATUS_OK : usage(option, text, "a number");
}

static int parse_rule(struct look_options *o, const char *text)
{
	char names[256] = "";
	o->choice.rule = rve_rule_find(text);
	for (const struct rve_rule *rule = rve_rules; rule->name; rule++)
		snprintf(names + strlen(names), sizeof names - strlen(names), "%s%s", *names ? ", " : "", rule->name);
	return o->choice.rule ? STATUS_OK : usage("rule", text, names);
}

static int parse_at(struct look_options *o, const char *text)
{
	char rest;
	return sscanf(text, "%lf,%lf%c", &o->choice.at[0], &o->choice.at[1], &rest) == 2 && isfinite(o->choice.at[0]) &&
				   isfinite(o->choice.at[1])
			   ? STATUS_OK
			   : usage("at", text, "a place x,y in m");
}

static int parse_point(struct look_options *o, const char *text)
{
	char *end;
	o->choice.point = strtoll(text, &end, 10);
	return *text && !*end && o->choice.point >= 0 && o->choice.point <= INT_MAX
			   ? STATUS_OK
			   : usage("point", text, "the number of a point");
}

static int parse_size(struct look_options *o, const char *text)
{
	char rest;
	bool fits = sscanf(text, "%dx%d%c", &o->size[0], &o->size[1], &rest) == 2;
	for (int k = 0; k < 2; k++)
		fits = fits && o->size[k] >= 16 && o->size[k] <= 8192;
	return fits ? STATUS_OK : usage("size", text, "WIDTHxHEIGHT in pixels, 16 to 8192 each");
}

/* One of a list of words. */
static int parse_word(const char *option, const char *text, const char *const *words, char to[FRAME_NAME])
{
	char all[256] = "";
	for (; *words; words++) {
		if (!strcmp(text, *words))
			return snprintf(to, FRAME_NAME, "%s", text), STATUS_OK;
		snprintf(all + strlen(all), sizeof all - strlen(all), "%s%s", *all ? ", " : "", *words);
	}
	return usage(option, text, all);
}

static int take_option(struct look_options *o, int option, const char *text)
{
	static const char *const fields[] = {"displacement", "rotation", "coordination", "temperature", "radius", NULL};
	static const char *const maps[] = {"viridis", "inferno", "coolwarm", NULL};
	o->n_choices += strchr("parn", option) != NULL;
	switch (option) {
	case 'p':
		return parse_point(o, text);
	case 'a':
		return parse_at(o, text);
	case 'r':
		return parse_rule(o, text);
	case 'n':
		o->choice.name = text;
		return STATUS_OK;
	case 't':
		return parse_number("time", text, &o->time);
	case 'b':
		o->before = text;
		return STATUS_OK;
	case 'i':
		o->image = text;
		return file_has_end(text, ".png") ? STATUS_OK : usage("image", text, "a name that ends in .png");
	case 'f':
		return parse_word("field", text, fields, o->field);
	case 'm':
		return parse_word("map", text, maps, o->map);
	case 's':
		return parse_size(o, text);
	case 'v':
		o->vtp = text;
		return STATUS_OK;
	case 'o':
		o->out = text;
		return file_has_end(text, ".h5") ? STATUS_OK : usage("out", text, "a name that ends in .h5");
	default:
		o->help = true;
		return STATUS_OK;
	}
}

static int parse(struct look_options *o, bool extract, int argc, char **argv)
{
	static const struct option both[] = {{"point", 1, NULL, 'p'}, {"at", 1, NULL, 'a'},   {"rule", 1, NULL, 'r'},
										 {"name", 1, NULL, 'n'},  {"time", 1, NULL, 't'}, {"help", 0, NULL, 'h'}};
	static const struct option of_show[] = {{"before", 1, NULL, 'b'}, {"image", 1, NULL, 'i'}, {"field", 1, NULL, 'f'},
											{"map", 1, NULL, 'm'},    {"size", 1, NULL, 's'},  {"vtp", 1, NULL, 'v'}};
	static const struct option of_extract[] = {{"out", 1, NULL, 'o'}};
	struct option list[16] = {{0}};
	memcpy(list, both, sizeof both);
	memcpy(list + sizeof both / sizeof *both, extract ? of_extract : of_show,
		   extract ? sizeof of_extract : sizeof of_show);
	*o = (struct look_options){.time = NAN, .choice = {.point = -1, .at = {NAN, NAN}}};
	opterr = 0;
	optind = 0; /* glibc: start afresh */
	for (int found; (found = getopt_long(argc, argv, ":h", list, NULL)) != -1;) {
		if (found == ':')
			return error_set(STATUS_INPUT, "%s has no value", argv[optind - 1]);
		if (found == '?')
			return error_set(STATUS_INPUT, "unknown option %s", argv[optind - 1]);
		CHECK(take_option(o, found, optarg));
	}
	if (o->help)
		return STATUS_OK;
	if (optind + 1 != argc)
		return error_set(STATUS_INPUT, "%d files are named, expected one: a run's folder, a file of it, or an RVE file",
						 argc - optind);
	o->source = argv[optind];
	if (o->n_choices > 1)
		return error_set(STATUS_INPUT, "several of --point, --at, --rule and --name are given, expected one of them");
	return STATUS_OK;
}

static void print_help(bool extract)
{
	fputs(extract ? help_extract : help_show, stdout);
	for (const struct rve_rule *rule = rve_rules; rule->name; rule++)
		printf("%s%s (%s)\n", rule == rve_rules ? "" : "                   ", rule->name, rule->doc);
	fputs(extract ? help_extract_rest : help_show_rest, stdout);
}

/* An output that could not be written is told before anything is read. */
static int check_writable(const char *path)
{
	char folder[FILE_PATH];
	if (!path)
		return STATUS_OK;
	CHECK(file_folder(folder, path));
	return access(folder, W_OK) == 0
			   ? STATUS_OK
			   : error_set(STATUS_RESOURCE, "cannot write %s: %s is no folder that can be written to", path, folder);
}

/* ---- show ---- */

static void print_look(const struct look *look)
{
	const struct frame_rve_view *view = &look->view;
	struct rve_info info;
	double strain[3];
	rve_get_info(view->model, view->state, &info);
	mat2_log_stretch(view->F, strain);
	printf("from           %s", look->source);
	if (look->skip >= 0)
		printf(", step %lld, t = %.9g s", look->origin.step, look->origin.time);
	printf("\n");
	if (look->origin.point >= 0)
		printf("point          %lld%s%s%s", look->origin.point, *look->origin.name ? " (" : "", look->origin.name,
			   *look->origin.name ? ")" : "");
	if (look->origin.point >= 0 && !isnan(look->x[0]))
		printf(" at (%.6g, %.6g) m", look->x[0], look->x[1]);
	printf("%s", look->origin.point >= 0 ? "\n" : "");
	printf("stress         xx %.6g, yy %.6g, zz %.6g, xy %.6g Pa (tension-positive)\n", view->stress[0],
		   view->stress[1], view->stress[2], view->stress[3]);
	printf("strain         xx %.6g, yy %.6g, xy %.6g (ln U)\n", strain[0], strain[1], strain[2]);
	if (view->thermal)
		printf("temperature    %.6g %s\n", view->temperature, view->celsius ? "C" : "K");
	printf("void ratio     %.6f\n", info.void_ratio);
	printf("contacts       %d, coordination %.4f, %.1f%% sliding\n", info.n_contacts, info.coordination,
		   100.0 * info.sliding_fraction);
	if (info.bonds_installed > 0)
		printf("bonds          %d of %d intact\n", info.bonds_intact, info.bonds_installed);
	if (info.flags)
		printf("state          %s\n",
			   info.flags & RVE_GAS ? "flies free, carries no stress" : "frozen: its cell follows no more");
}

static int write_vtp(const void *frame, const char *name)
{
	static const char *const what[] = {"discs", "contacts"};
	for (int k = 0; k < 2; k++) {
		char path[FILE_PATH];
		if (snprintf(path, sizeof path, "%s_%s.vtp", name, what[k]) >= (int)sizeof path)
			return error_set(STATUS_INPUT, "--vtp %s: too long a name", name);
		CHECK(vtk_write(path, frame, k));
		printf("wrote          %s\n", path);
	}
	return STATUS_OK;
}

static void describe_image(struct frame_image *image, const struct look_options *o, const struct look *look,
						   const struct look *before)
{
	*image = (struct frame_image){.kind = 1, .component = -1, .view = {NAN, NAN, NAN, NAN}, .range_auto = 1};
	snprintf(image->name, sizeof image->name, "rve");
	snprintf(image->rve, sizeof image->rve, "%s", look->view.name);
	snprintf(image->before, sizeof image->before, "%s", before ? before->view.name : "");
	snprintf(image->field, sizeof image->field, "%s", *o->field ? o->field : "displacement");
	snprintf(image->map, sizeof image->map, "%s",
			 *o->map                            ? o->map
			 : strcmp(image->field, "rotation") ? "viridis"
												: "coolwarm");
	image->size[0] = o->size[0] ? o->size[0] : before ? 1600 : 1000;
	image->size[1] = o->size[1] ? o->size[1] : before ? 740 : 800;
}

static int draw(const struct look_options *o, const struct look *look, const struct look *before, const void *frame,
				int64_t bytes)
{
	struct frame_image image;
	struct viewer *viewer = NULL;
	char failure[1024] = "", log[FILE_PATH];
	CHECK(file_scratch(log, "viewer"));
	describe_image(&image, o, look, before);
	int status = viewer_start(&viewer, 1, &image, log);
	CHECK(status); /* with the name of the log, which stays */
	status = viewer_draw(viewer, frame, bytes, 0, o->image);
	if (status == STATUS_OK)
		status = viewer_flush(viewer);
	const char *notice = viewer_notice(viewer);
	snprintf(failure, sizeof failure, "%s", notice ? notice : "");
	int failed = viewer_finish(viewer);
	unlink(log); /* what a viewer says by the way matters to nobody here */
	if (status == STATUS_OK && failed > 0)
		status = error_set(STATUS_RESOURCE, "%s", *failure ? failure : "the picture could not be drawn");
	if (status == STATUS_OK)
		printf("wrote          %s\n", o->image);
	return status;
}

/* The frame of one RVE, or of the same (or another) before and after. */
static int show_outputs(const struct look_options *o, const struct look *look, struct look *before)
{
	struct frame_builder *builder = frame_builder_create();
	if (!builder)
		return error_set(STATUS_RESOURCE, "out of memory");
	int64_t bytes = 0;
	frame_begin(builder, look->origin.step, look->origin.time, look->title, look->view.celsius ? "C" : "K");
	int status = frame_rve_add(builder, &look->view);
	if (status == STATUS_OK && before) {
		before->view.name = "before";
		status = frame_rve_add(builder, &before->view);
	}
	const void *frame = status == STATUS_OK ? frame_finish(builder, &bytes) : NULL;
	if (status == STATUS_OK && !frame)
		status = error_set(STATUS_RESOURCE, "out of memory");
	if (status == STATUS_OK && o->vtp)
		status = write_vtp(frame, o->vtp);
	if (status == STATUS_OK && o->image)
		status = draw(o, look, before, frame, bytes);
	frame_builder_free(builder);
	return status;
}

/* The same point at another time of the run, or what is in another file. */
static int open_before(const struct look_options *o, const struct look *look, struct look *before)
{
	char *end;
	double time = strtod(o->before, &end);
	struct look_choice choice = {.point = look->origin.point, .at = {NAN, NAN}};
	if (*end || !isfinite(time))
		return look_open(before, o->before, NAN, &choice);
	if (!*look->folder)
		return error_set(STATUS_INPUT, "--before %s: %s is of no run, expected another file", o->before, o->source);
	return look_open(before, look->folder, time, &choice);
}

static int show(const struct look_options *o)
{
	struct look look, before = {0};
	CHECK(check_writable(o->image));
	CHECK(check_writable(o->vtp));
	int status = look_open(&look, o->source, o->time, &o->choice);
	if (status == STATUS_OK && o->before)
		status = open_before(o, &look, &before);
	if (status == STATUS_OK)
		print_look(&look);
	if (status == STATUS_OK && o->before) {
		printf("\nbefore\n");
		print_look(&before);
	}
	if (status == STATUS_OK && (o->image || o->vtp))
		status = show_outputs(o, &look, o->before ? &before : NULL);
	look_close(&before);
	look_close(&look);
	return status;
}

/* ---- extract ---- */

static void print_replay(const struct look_options *o, const struct look *look)
{
	if (*look->path)
		printf("drive it on    tmdempm rve load --packing %s --load path --path %s --skip %lld --out curve.csv\n",
			   o->out, look->path, look->skip);
	else
		printf(
			"drive it on    tmdempm rve load --packing %s --load biaxial --lateral 10e3 --rate 1 --strain 0.05 --out "
			"curve.csv\n",
			o->out);
}

static int extract(const struct look_options *o)
{
	struct look look;
	if (!o->out)
		return error_set(STATUS_INPUT, "--out is missing, expected the RVE file to write, as in --out P.h5");
	CHECK(check_writable(o->out));
	int status = look_open(&look, o->source, o->time, &o->choice);
	if (status == STATUS_OK)
		status = rve_file_write(o->out, look.view.model, look.view.state, &look.origin);
	if (status == STATUS_OK) {
		print_look(&look);
		printf("wrote          %s\n", o->out);
		print_replay(o, &look);
	}
	look_close(&look);
	return status;
}

bool cli_look_has(const char *verb) { return !strcmp(verb, "show") || !strcmp(verb, "extract"); }

int cli_look(int argc, char **argv)
{
	struct look_options o;
	bool takes_out = !strcmp(argv[0], "extract");
	int status = parse(&o, takes_out, argc, argv);
	if (status == STATUS_OK && o.help) {
		print_help(takes_out);
		return STATUS_OK;
	}
	bool usage_error = status != STATUS_OK;
	if (status == STATUS_OK)
		status = takes_out ? extract(&o) : show(&o);
	if (status != STATUS_OK)
		fprintf(stderr, "tmdempm rve %s: %s\n", argv[0], error_message());
	if (usage_error)
		fprintf(stderr, "`tmdempm rve %s --help` lists the options\n", argv[0]);
	return status;
}
