#include "rve/cli.h"

#include <errno.h>
#include <getopt.h>
#include <limits.h>
#include <math.h>
#include <omp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/error.h"
#include "io/csv.h"
#include "io/file.h"
#include "rve/drive.h"
#include "rve/from_scene.h"
#include "rve/packing.h"
#include "rve/rve.h"

static const char help_rve[] = "usage: tmdempm rve pack|load|info|show|extract ...\n"
							   "\n"
							   "  pack     makes a packing: the start state of an RVE\n"
							   "  load     drives one RVE alone and writes its curve\n"
							   "  info     says what is in a packing or an RVE file\n"
							   "  show     draws an RVE of a run, a packing or an RVE file\n"
							   "  extract  takes an RVE out of a run: an RVE file that load drives on\n"
							   "\n"
							   "`tmdempm rve VERB --help` lists the options of each.\n";

#define PACKING_OPTIONS                                                                                                \
	"  --discs N            discs in the cell (400)\n"                                                                 \
	"  --pressure P         isotropic consolidation pressure, Pa\n"                                                    \
	"  --seed S             of the random placement (1)\n"                                                             \
	"  --void-ratio E       target void ratio: the friction is found by bisection\n"                                   \
	"  --radius-min R       m (0.25e-3); radii are uniform between the two\n"                                          \
	"  --radius-max R       m (0.5e-3)\n"                                                                              \
	"  --lattice square     noise-free square lattice of discs of radius-max; N is a square\n"

static const char help_pack[] =
	"usage: tmdempm rve pack --pressure P --mu M --out FILE.h5|FILE.csv [options]\n"
	"\n"
	"Random placement, isotropic compression by a servo, hold.  A packing is a pure function of its options;\n"
	"it is kept in $XDG_CACHE_HOME/tmdempm/packings (or ~/.cache) and found there the next time.\n"
	"\n" PACKING_OPTIONS "  --mu M               friction while it is compressed (not with --void-ratio or --lattice)\n"
	"  --out FILE           .h5 keeps every bit, .csv the discs without their tangential forces\n";

static const char help_load[] =
	"usage: tmdempm rve load --packing FILE --load isochoric|biaxial|shear|iso --rate R --strain E --out CURVE.csv\n"
	"       tmdempm rve load --packing FILE --load path --path PATH.csv --out CURVE.csv\n"
	"       tmdempm rve load --scene SCENE.cfg [--law NAME] --load path --path PATH.csv --out CURVE.csv\n"
	"       tmdempm rve load --packing RVE.h5 --load path --path PATH.csv --skip N --out CURVE.csv\n"
	"\n"
	"Stress is tension-positive, strain is ln U.  The load is\n"
	"  isochoric  L = diag(R, -R)\n"
	"  biaxial    y is shortened at R, a servo holds sigma_xx at -P (--lateral)\n"
	"  shear      L_xy = R at constant volume\n"
	"  iso        a servo no faster than R brings sigma to -P (--lateral) and holds it there\n"
	"  path       rows duration,L11,L12,L21,L22,dT[,T,bonds] as a run records them in rve/NAME_path.csv\n"
	"\n"
	"  --packing FILE       .h5 or .csv; an RVE file (rve extract) goes on with its state, its bonds and its law's\n"
	"                       parameters, where --scene does not give others; or one is generated (cached) "
	"from\n" PACKING_OPTIONS "  --mu-pack M          friction while it is compressed\n"
	"  --scene FILE         takes all parameters, also the packing, from an RVE law of a scene;\n"
	"  --law NAME           needed if the scene has several; --seed then chooses a variant's packing\n"
	"  --set path=value     changes the scene as `tmdempm run` does; any number of times\n"
	"  --rate R             1/s\n"
	"  --strain E           R times the duration\n"
	"  --lateral P          Pa (the packing's own pressure)\n"
	"  --mu M               friction between discs (0.5)\n"
	"  --temperature dT     K, heats the RVE before the load\n"
	"  --bond-beta B        bonds between discs in contact, installed at rest before the heating (of a path: where it\n"
	"                       says so); they bear B kn R in tension (0, no bonds)\n"
	"  --mu-bond M          and M times that in shear (0.5)\n"
	"  --bond-melting dT    K of heating beyond which they break (never)\n"
	"  --strain-per-step S  a sub-step strains by min(R dt, S) (5e-5); of a path: the largest\n"
	"  --rows N             rows after the first (200; of a path: all)\n"
	"  --path FILE          the path to replay\n"
	"  --skip N             without its first N rows: those that an RVE file has behind it (0)\n"
	"  --out FILE.csv       the curve\n"
	"  --save FILE.h5       the RVE at the end, as an RVE file\n";

static const char help_info[] =
	"usage: tmdempm rve info FILE.h5|FILE.csv\n"
	"\n"
	"Prints discs, cell, void ratio, stress, coordination, conductivity, elasticity, anisotropy; of an RVE file also\n"
	"where it comes from.\n";

/* ---- options ---- */

enum { SETS_MAX = 64 };

struct options {
	const char *packing, *out, *load, *path, *lattice, *scene, *law, *save;
	double pressure, mu, mu_pack, void_ratio, radius_min, radius_max, rate, strain, lateral, temperature,
		strain_per_step, bond_beta, mu_bond, bond_melting;
	long discs, seed, rows, skip;
	bool help;
	int n_sets;
	const char *sets[SETS_MAX];
	int n_files; /* arguments without an option */
	char **files;
};

enum value_kind { VALUE_TEXT, VALUE_NUMBER, VALUE_COUNT, VALUE_NONE, VALUE_LIST };

/* One option: where its value goes, and what it must be. */
struct option_rule {
	const char *name;
	enum value_kind kind;
	size_t offset;
	double min;     /* numbers and counts */
	bool exclusive; /* min itself is not allowed */
	const char *expected;
	int verbs; /* bits of enum verb */
};

enum verb { VERB_PACK = 1, VERB_LOAD = 2, VERB_INFO = 4 };

#define AT(field) offsetof(struct options, field)

static const struct option_rule rules[] = {
	{"help", VALUE_NONE, AT(help), 0, false, "", VERB_PACK | VERB_LOAD | VERB_INFO},
	{"packing", VALUE_TEXT, AT(packing), 0, false, "", VERB_LOAD},
	{"load", VALUE_TEXT, AT(load), 0, false, "", VERB_LOAD},
	{"path", VALUE_TEXT, AT(path), 0, false, "", VERB_LOAD},
	{"scene", VALUE_TEXT, AT(scene), 0, false, "", VERB_LOAD},
	{"set", VALUE_LIST, 0, 0, false, "", VERB_LOAD},
	{"law", VALUE_TEXT, AT(law), 0, false, "", VERB_LOAD},
	{"rate", VALUE_NUMBER, AT(rate), 0, true, "a strain rate above 0 (1/s)", VERB_LOAD},
	{"strain", VALUE_NUMBER, AT(strain), 0, false, "a strain, 0 or more", VERB_LOAD},
	{"lateral", VALUE_NUMBER, AT(lateral), 0, true, "a pressure above 0 (Pa)", VERB_LOAD},
	{"temperature", VALUE_NUMBER, AT(temperature), -HUGE_VAL, false, "a temperature change (K)", VERB_LOAD},
	{"strain-per-step", VALUE_NUMBER, AT(strain_per_step), 0, true, "a strain above 0", VERB_LOAD},
	{"rows", VALUE_COUNT, AT(rows), 1, false, "a whole number of rows, 1 or more", VERB_LOAD},
	{"skip", VALUE_COUNT, AT(skip), 0, false, "a whole number of rows, 0 or more", VERB_LOAD},
	{"save", VALUE_TEXT, AT(save), 0, false, "", VERB_LOAD},
	{"mu-pack", VALUE_NUMBER, AT(mu_pack), 0, false, "a friction coefficient, 0 or more", VERB_LOAD},
	{"bond-beta", VALUE_NUMBER, AT(bond_beta), 0, false, "a strength, 0 or more", VERB_LOAD},
	{"mu-bond", VALUE_NUMBER, AT(mu_bond), 0, false, "a ratio of shear to tensile strength, 0 or more", VERB_LOAD},
	{"bond-melting", VALUE_NUMBER, AT(bond_melting), -HUGE_VAL, false, "a temperature change (K)", VERB_LOAD},
	{"mu", VALUE_NUMBER, AT(mu), 0, false, "a friction coefficient, 0 or more", VERB_PACK | VERB_LOAD},
	{"discs", VALUE_COUNT, AT(discs), 1, false, "a whole number of discs", VERB_PACK | VERB_LOAD},
	{"pressure", VALUE_NUMBER, AT(pressure), 0, true, "a pressure above 0 (Pa)", VERB_PACK | VERB_LOAD},
	{"seed", VALUE_COUNT, AT(seed), 0, false, "a whole number, 0 or more", VERB_PACK | VERB_LOAD},
	{"void-ratio", VALUE_NUMBER, AT(void_ratio), 0, true, "a void ratio above 0", VERB_PACK | VERB_LOAD},
	{"radius-min", VALUE_NUMBER, AT(radius_min), 0, true, "a radius above 0 (m)", VERB_PACK | VERB_LOAD},
	{"radius-max", VALUE_NUMBER, AT(radius_max), 0, true, "a radius above 0 (m)", VERB_PACK | VERB_LOAD},
	{"lattice", VALUE_TEXT, AT(lattice), 0, false, "", VERB_PACK | VERB_LOAD},
	{"out", VALUE_TEXT, AT(out), 0, false, "", VERB_PACK | VERB_LOAD},
};
enum { RULES = sizeof rules / sizeof *rules };

static int usage_error(const char *format, ...) __attribute__((format(printf, 1, 2)));

static int usage_error(const char *format, ...)
{
	char text[1024];
	va_list args;
	va_start(args, format);
	vsnprintf(text, sizeof text, format, args);
	va_end(args);
	return error_set(STATUS_INPUT, "%s", text);
}

static int set_option(struct options *o, const struct option_rule *rule, const char *text)
{
	char *at = (char *)o + rule->offset, *end;
	if (rule->kind == VALUE_NONE) {
		*(bool *)at = true;
		return STATUS_OK;
	}
	if (rule->kind == VALUE_LIST) {
		if (o->n_sets == SETS_MAX)
			return usage_error("--%s is given more than %d times", rule->name, SETS_MAX);
		o->sets[o->n_sets++] = text;
		return STATUS_OK;
	}
	if (rule->kind == VALUE_TEXT) {
		*(const char **)at = text;
		return *text ? STATUS_OK : usage_error("--%s is empty", rule->name);
	}
	double value = strtod(text, &end);
	bool fits =
		end != text && !*end && isfinite(value) && value >= rule->min && !(rule->exclusive && value == rule->min);
	bool whole = rule->kind == VALUE_NUMBER || (value == rint(value) && value <= INT_MAX);
	if (!fits || !whole)
		return usage_error("--%s is \"%s\", expected %s", rule->name, text, rule->expected);
	if (rule->kind == VALUE_NUMBER)
		*(double *)at = value;
	else
		*(long *)at = (long)value;
	return STATUS_OK;
}

/* argv[0] is the verb. */
static int parse(struct options *o, int verb, int argc, char **argv)
{
	struct option list[RULES + 1] = {0};
	int n = 0, index[RULES], found;
	*o = (struct options){.pressure = NAN,
						  .mu = NAN,
						  .mu_pack = NAN,
						  .void_ratio = NAN,
						  .radius_min = NAN,
						  .radius_max = NAN,
						  .rate = NAN,
						  .strain = NAN,
						  .lateral = NAN,
						  .temperature = NAN,
						  .strain_per_step = NAN,
						  .bond_beta = NAN,
						  .mu_bond = NAN,
						  .bond_melting = NAN,
						  .discs = -1,
						  .seed = -1,
						  .rows = -1};
	for (int k = 0; k < RULES; k++)
		if (rules[k].verbs & verb) {
			index[n] = k;
			list[n++] = (struct option){rules[k].name, rules[k].kind != VALUE_NONE, NULL, 0};
		}
	opterr = 0;
	optind = 0; /* glibc: start afresh */
	for (int which; (found = getopt_long(argc, argv, ":h", list, &which)) != -1;) {
		if (found == 'h')
			o->help = true;
		else if (found == ':')
			return usage_error("%s has no value", argv[optind - 1]);
		else if (found == '?')
			return usage_error("unknown option %s", argv[optind - 1]);
		else
			CHECK(set_option(o, &rules[index[which]], optarg));
	}
	o->n_files = argc - optind;
	o->files = argv + optind;
	return STATUS_OK;
}

static int missing(const char *option, const char *expected)
{
	return usage_error("--%s is missing, expected %s", option, expected);
}

/* An output that could not be written is told before anything is computed. */
static int check_file(const char *option, const char *path, const char *end, const char *other)
{
	char folder[FILE_PATH];
	if (!file_has_end(path, end) && !(other && file_has_end(path, other)))
		return usage_error("--%s is %s, expected a name that ends in %s%s%s", option, path, end, other ? " or " : "",
						   other ? other : "");
	CHECK(file_folder(folder, path));
	if (access(folder, W_OK) != 0)
		return error_set(STATUS_RESOURCE, "cannot write %s: %s: %s", path, folder, strerror(errno));
	return STATUS_OK;
}

static int check_out(const char *out, const char *end, const char *other)
{
	return out ? check_file("out", out, end, other) : missing("out", "the file to write");
}

static int no_files(const struct options *o)
{
	return o->n_files == 0 ? STATUS_OK : usage_error("unexpected argument \"%s\"", o->files[0]);
}

/* ---- packings from options ---- */

static double or_default(double value, double otherwise) { return isnan(value) ? otherwise : value; }

/* mu: --mu of pack, --mu-pack of load. */
static int packing_params(struct rve_packing_params *how, const struct options *o, double mu, const char *mu_option)
{
	if (o->lattice && strcmp(o->lattice, "square") != 0)
		return usage_error("--lattice is \"%s\", expected square", o->lattice);
	*how = (struct rve_packing_params){
		.discs = o->discs < 0 ? 400 : (int)o->discs,
		.radius_min = or_default(o->radius_min, 0.25e-3),
		.radius_max = or_default(o->radius_max, 0.5e-3),
		.pressure = o->pressure,
		.mu = or_default(mu, 0.0),
		.void_ratio = o->void_ratio,
		.seed = o->seed < 0 ? 1 : (unsigned)o->seed,
		.square_lattice = o->lattice != NULL,
	};
	if (isnan(o->pressure))
		return missing("pressure", "the consolidation pressure in Pa, as in --pressure 10e3");
	if (isnan(mu) && isnan(o->void_ratio) && !o->lattice)
		return missing(mu_option, "the friction during consolidation, or --void-ratio");
	if (!isnan(mu) && !isnan(o->void_ratio))
		return usage_error("--%s and --void-ratio are both given, expected one: a void ratio is reached by "
						   "adjusting the friction",
						   mu_option);
	if (o->lattice && isnan(o->radius_min))
		how->radius_min = how->radius_max;
	if (how->radius_min > how->radius_max)
		return usage_error("--radius-min %g is above --radius-max %g, expected it below", how->radius_min,
						   how->radius_max);
	return STATUS_OK;
}

static int cmd_pack(const struct options *o)
{
	struct rve_packing_params how;
	struct rve_params grains;
	struct rve_packing *packing;
	CHECK(no_files(o));
	CHECK(packing_params(&how, o, o->mu, "mu"));
	CHECK(check_out(o->out, ".h5", ".csv"));
	rve_params_default(&grains);
	CHECK(rve_packing_cached(&packing, &how, &grains));
	int status = rve_packing_write(packing, o->out);
	if (status == STATUS_OK)
		printf("%s: %d discs, void ratio %.4f at %.4g Pa, seed %u\n", o->out, packing->n_discs,
			   rve_packing_void_ratio(packing), packing->pressure, packing->seed);
	rve_packing_free(packing);
	return status;
}

/* ---- load ---- */

static volatile int stop;

static void on_signal(int number)
{
	(void)number;
	stop = 1;
}

static int check_load(const struct options *o, struct rve_drive *drive)
{
	int load = o->load ? rve_load_find(o->load) : -1;
	if (!o->load)
		return missing("load", "isochoric, biaxial, shear, iso or path");
	if (load < 0)
		return usage_error("--load is \"%s\", expected isochoric, biaxial, shear, iso or path", o->load);
	bool path = load == RVE_LOAD_PATH, servo = load == RVE_LOAD_BIAXIAL || load == RVE_LOAD_ISO;
	if (path && !o->path)
		return missing("path", "the file with the path, rows duration,L11,L12,L21,L22,dT");
	if (!path && o->path)
		return usage_error("--path is given with --load %s, expected it with --load path only", o->load);
	if (path && (!isnan(o->rate) || !isnan(o->strain) || !isnan(o->temperature) || !isnan(o->bond_melting)))
		return usage_error(
			"--rate, --strain, --temperature and --bond-melting are not for --load path: the file says them");
	if (!servo && !isnan(o->lateral))
		return usage_error("--lateral is given with --load %s, expected it with biaxial or iso", o->load);
	if (!path && o->skip > 0)
		return usage_error("--skip is given with --load %s, expected it with --load path only", o->load);
	if (!path && isnan(o->rate))
		return missing("rate", "the strain rate in 1/s, as in --rate 1");
	if (!path && isnan(o->strain))
		return missing("strain", "the strain to reach, as in --strain 0.1");
	*drive = (struct rve_drive){.load = (enum rve_load)load,
								.rate = o->rate,
								.strain = o->strain,
								.pressure = o->lateral,
								.temperature = or_default(o->temperature, 0.0),
								.strain_per_step = o->strain_per_step,
								.rows = o->rows > 0 ? (int)o->rows
										: path      ? 0
													: 200,
								.skip = (int)o->skip,
								.install = o->bond_beta > 0.0,
								.save = o->save,
								.stop = &stop};
	return STATUS_OK;
}

static const struct scene_law *find_law(const struct scene *scene, const char *name)
{
	const struct scene_law *found = NULL;
	int n = 0;
	for (int k = 0; k < scene->n_laws; k++) {
		const struct scene_law *law = &scene->laws[k];
		if (law->type != SCENE_LAW_RVE || (name && strcmp(law->name, name) != 0))
			continue;
		found = law;
		n++;
	}
	return n == 1 ? found : NULL;
}

/* Is any option given that says how to make a packing? */
static bool makes_packing(const struct options *o)
{
	return o->discs >= 0 || !isnan(o->pressure) || !isnan(o->mu_pack) || !isnan(o->void_ratio) ||
		   !isnan(o->radius_min) || !isnan(o->radius_max) || o->lattice;
}

/* What a load begins with: a packing, or an RVE that goes on. */
struct start {
	struct rve_packing *packing;
	struct rve_file *file;
};

static int from_scene(const struct options *o, struct rve_params *params, struct start *start)
{
	struct scene *scene;
	if (makes_packing(o))
		return usage_error(
			"options for making a packing are given beside --scene, expected --packing or the scene's own");
	int status = scene_load(&scene, o->scene, o->n_sets, o->sets, stderr);
	if (status != STATUS_OK)
		return error_set(status, "%s cannot be used", o->scene);
	const struct scene_law *law = find_law(scene, o->law);
	if (!law) {
		status = o->law ? usage_error("%s has no RVE law \"%s\"", o->scene, o->law)
						: usage_error("%s has no RVE law, or several, expected --law NAME", o->scene);
	} else {
		struct scene_law_rve rve = law->rve;
		rve.packing.seed = o->seed < 0 ? rve.packing.seed : (unsigned)o->seed;
		const int path = params->path;
		rve_params_from_scene(params, &rve);
		if (start->file && rve.path == SCENE_RVE_AUTO)
			params->path = path; /* the one that its state is of */
		if (!o->packing)
			status = rve_packing_from_scene(&start->packing, &rve, 0);
	}
	scene_free(scene);
	return status;
}

static void start_free(struct start *start)
{
	rve_packing_free(start->packing);
	rve_file_free(start->file);
	*start = (struct start){0};
}

static int get_packing(const struct options *o, const struct rve_params *params, struct rve_packing **packing)
{
	struct rve_packing_params how;
	if (o->packing)
		return rve_packing_read(packing, o->packing);
	if (isnan(o->pressure))
		return missing("packing", "a file, or --pressure and --mu-pack to generate one, or --scene");
	CHECK(packing_params(&how, o, o->mu_pack, "mu-pack"));
	return rve_packing_cached(packing, &how, params);
}

/* Parameters and start of a load. */
static int get_rve(const struct options *o, struct rve_params *params, struct start *start)
{
	rve_params_default(params);
	params->path = RVE_SIMD;
	if ((o->law || o->n_sets) && !o->scene)
		return usage_error("--%s is given without --scene, expected the scene that it is for", o->law ? "law" : "set");
	if (o->packing && makes_packing(o))
		return usage_error("--packing and options for making one are both given, expected one of them");
	if (o->packing && rve_file_is(o->packing)) {
		CHECK(rve_file_read(&start->file, o->packing));
		*params = start->file->params;
	}
	if (o->scene)
		CHECK(from_scene(o, params, start));
	if (!start->packing && !start->file)
		CHECK(get_packing(o, params, &start->packing));
	params->mu = or_default(o->mu, params->mu);
	params->strain_per_step = or_default(o->strain_per_step, params->strain_per_step);
	return STATUS_OK;
}

static int write_row(void *context, const double row[RVE_COLUMNS])
{
	struct csv_writer *w = context;
	for (int k = 0; k < RVE_COLUMNS; k++)
		csv_number(w, row[k]);
	return csv_end_row(w);
}

/* What a reader of the curve should know. */
static void report(const struct rve_drive_report *r, const char *out, double seconds)
{
	const struct rve_info *last = &r->last;
	printf("%s: %d rows, %lld sub-steps in %.3g s\n", out, r->rows, last->total_sub_steps, seconds);
	if (r->rows_off_pressure == r->rows)
		fprintf(stderr, "tmdempm rve load: warning: the pressure is not reached, a larger --strain is needed\n");
	else if (r->rows_off_pressure > 0)
		fprintf(stderr,
				"tmdempm rve load: warning: in %d of %d rows the held stress is more than 1%% off; a smaller --rate "
				"or --strain-per-step holds it better\n",
				r->rows_off_pressure, r->rows);
	if (last->bonds_installed > 0)
		printf("bonds: %d of %d intact\n", last->bonds_intact, last->bonds_installed);
	if (last->reseeded > 0)
		fprintf(stderr, "tmdempm rve load: warning: the cell became too slender and was replaced %d times\n",
				last->reseeded);
	if (last->flags & RVE_FROZEN)
		fprintf(stderr, "tmdempm rve load: warning: the cell became too slender and was frozen\n");
	if (last->flags & RVE_GAS)
		fprintf(stderr, "tmdempm rve load: warning: the RVE flies free (gas) at the end\n");
}

/* Rows until a guard are worth having: the curve ends there, and the message says so. */
static int write_curve(const struct options *o, const struct rve_packing *packing, const struct rve_params *params,
					   const struct rve_drive *drive)
{
	struct csv_writer *w;
	struct rve_drive_report r;
	clock_t start = clock();
	CHECK(csv_create(&w, o->out));
	for (int k = 0; k < RVE_COLUMNS; k++)
		csv_name(w, rve_columns[k].name, rve_columns[k].unit);
	int status = csv_end_row(w);
	if (status == STATUS_OK)
		status = rve_drive(packing, params, drive, write_row, w, &r);
	if (status == STATUS_GUARD && r.rows > 0) {
		CHECK(csv_close(w));
		return error_context(status, "%s ends after %d rows", o->out, r.rows);
	}
	if (status != STATUS_OK) {
		csv_abandon(w);
		return status;
	}
	CHECK(csv_close(w));
	report(&r, o->out, (double)(clock() - start) / CLOCKS_PER_SEC);
	return STATUS_OK;
}

static int check_path(const struct options *o, const struct rve_path *path, const struct rve_file *from)
{
	if (o->skip >= path->n)
		return usage_error("--skip %ld leaves nothing of the %d rows of %s", o->skip, path->n, o->path);
	if (o->bond_beta > 0.0 && !path->bonded)
		return usage_error("--bond-beta is given, but %s has no column that says when bonds are installed", o->path);
	if (from && from->params.bond_strength > 0.0 && isfinite(from->params.bond_melting) && !path->bonded)
		return usage_error("--path %s has no columns T,bonds, but the bonds of %s melt by temperature", o->path,
						   o->packing);
	return STATUS_OK;
}

static int drive_start(const struct options *o, struct rve_drive *drive, const struct rve_params *params,
					   const struct start *start)
{
	struct rve_path path = {0};
	bool servo = drive->load == RVE_LOAD_BIAXIAL || drive->load == RVE_LOAD_ISO;
	if (servo && isnan(drive->pressure) && start->packing)
		drive->pressure = start->packing->pressure;
	if (servo && isnan(drive->pressure))
		return missing("lateral", "the pressure to hold in Pa (this packing does not name its own)");
	drive->strain_per_step = params->strain_per_step;
	if (o->path)
		CHECK(rve_path_read(&path, o->path));
	drive->path = &path;
	drive->from = start->file;
	int status = o->path ? check_path(o, &path, start->file) : STATUS_OK;
	if (status == STATUS_OK)
		status = write_curve(o, start->packing, params, drive);
	rve_path_free(&path);
	return status;
}

/* Bonds as the options change them.  A load knows temperature changes only, so where bonds melt is said as one; a
 * scene's law says an absolute temperature, and the start is then that much below it. */
static int set_bonds(const struct options *o, struct rve_params *params, struct rve_drive *drive,
					 const struct rve_file *from)
{
	params->bond_strength = or_default(o->bond_beta, params->bond_strength);
	params->bond_mu = or_default(o->mu_bond, params->bond_mu);
	if (!(params->bond_strength < params->skin))
		return usage_error("--bond-beta is %g, expected less than the skin of %g: bonded discs must stay neighbours",
						   params->bond_strength, params->skin);
	if (drive->load == RVE_LOAD_PATH || !(params->bond_strength > 0.0))
		return STATUS_OK;
	if (from && isnan(o->bond_melting) && !isnan(from->origin.T)) {
		drive->start_temperature = from->origin.T;
		return STATUS_OK;
	}
	if (isnan(o->bond_melting) && isfinite(params->bond_melting))
		return missing("bond-melting", "how far above the start the scene's bonds melt, in K");
	if (isinf(params->bond_melting))
		params->bond_melting = or_default(o->bond_melting, params->bond_melting);
	drive->start_temperature = isfinite(params->bond_melting) ? params->bond_melting - o->bond_melting : 0.0;
	return STATUS_OK;
}

static int cmd_load(const struct options *o)
{
	struct rve_drive drive;
	struct rve_params params;
	struct start start = {0};
	struct sigaction act = {.sa_handler = on_signal}, old_int, old_term;
	CHECK(no_files(o));
	CHECK(check_load(o, &drive));
	CHECK(check_out(o->out, ".csv", NULL));
	if (o->save)
		CHECK(check_file("save", o->save, ".h5", NULL));
	int status = get_rve(o, &params, &start);
	if (status == STATUS_OK)
		status = set_bonds(o, &params, &drive, start.file);
	if (status != STATUS_OK) {
		start_free(&start);
		return status;
	}
	stop = 0;
	sigaction(SIGINT, &act, &old_int);
	sigaction(SIGTERM, &act, &old_term);
	status = drive_start(o, &drive, &params, &start);
	sigaction(SIGINT, &old_int, NULL);
	sigaction(SIGTERM, &old_term, NULL);
	start_free(&start);
	return status;
}

/* ---- info ---- */

/* Second-order fabric of the contact normals: a = 2 sqrt(d^2 + xy^2) of <n n>, 0 (isotropic) .. 1; its direction,
 * degrees. */
static int anisotropy(const struct rve_model *model, const void *state, double *a, double *degrees)
{
	int capacity = rve_contact_capacity(model), used = 0;
	double d = 0.0, xy = 0.0;
	struct rve_contact *c = calloc((size_t)capacity + 1, sizeof *c);
	if (!c)
		return error_set(STATUS_RESOURCE, "no memory for %d contacts", capacity);
	int n = rve_inspect(model, state, NULL, c, capacity);
	for (int k = 0; k < n; k++) {
		double x = c[k].ends[1][0] - c[k].ends[0][0], y = c[k].ends[1][1] - c[k].ends[0][1], l2 = x * x + y * y;
		if (c[k].normal_force <= 0.0)
			continue;
		d += 0.5 * (x * x - y * y) / l2;
		xy += x * y / l2;
		used++;
	}
	free(c);
	*a = used ? 2.0 * hypot(d, xy) / used : 0.0;
	*degrees = 0.5 * atan2(xy, d) * 57.29577951308232;
	return STATUS_OK;
}

static void print_origin(const char *path, const struct rve_packing *p)
{
	double small = HUGE_VAL, large = 0.0;
	for (int i = 0; i < p->n_discs; i++) {
		small = fmin(small, p->r[i]);
		large = fmax(large, p->r[i]);
	}
	printf("packing        %s\n", path);
	printf("discs          %d, radii %.6g to %.6g m\n", p->n_discs, small, large);
	printf("cell           H = [%.9g %.9g; %.9g %.9g] m\n", p->H[0], p->H[1], p->H[2], p->H[3]);
	if (!isnan(p->pressure))
		printf("made           at %.6g Pa, mu %.6g, seed %u, unbalanced force ratio %.3g\n", p->pressure, p->mu,
			   p->seed, p->unbalanced);
	printf("void ratio     %.6f\n", rve_packing_void_ratio(p));
}

static int print_state(const struct rve_model *model, const void *state)
{
	struct rve_info info;
	double stress[4], k[3], modulus, a = 0.0, degrees = 0.0;
	rve_evaluate(model, state, stress, k, &modulus);
	rve_get_info(model, state, &info);
	CHECK(anisotropy(model, state, &a, &degrees));
	printf("stress         xx %.6g, yy %.6g, xy %.6g Pa (tension-positive)\n", stress[0], stress[1], stress[3]);
	printf("pressure       %.6g Pa\n", -0.5 * (stress[0] + stress[1]));
	printf("contacts       %d, coordination %.4f, largest overlap %.3g of a radius\n", info.n_contacts,
		   info.coordination, info.max_overlap);
	printf("conductivity   xx %.6g, yy %.6g, xy %.6g W/(m K)\n", k[0], k[1], k[2]);
	const double *D = info.elastic_tensor;
	printf("elastic tensor xxxx %.6g, yyyy %.6g, xxyy %.6g, xyxy %.6g, xxxy %.6g, yyxy %.6g Pa (affine)\n", D[0], D[1],
		   D[2], D[3], D[4], D[5]);
	printf("wave modulus   %.6g Pa\n", modulus);
	printf("anisotropy     %.4f of the contact normals, towards %.1f degrees\n", a, degrees);
	printf("time step      %.4g s\n", rve_time_step(model));
	return STATUS_OK;
}

static int print_info(const char *path, const struct rve_packing *packing)
{
	struct rve_params params;
	struct rve_model *model;
	rve_params_default(&params);
	CHECK(rve_model_create(&model, &params, 1, &packing));
	void *state = aligned_alloc(64, (rve_state_bytes(model) + 63) / 64 * 64);
	int status = state ? rve_init(model, 0, state) : error_set(STATUS_RESOURCE, "no memory for an RVE");
	if (status == STATUS_OK) {
		print_origin(path, packing);
		status = print_state(model, state);
	}
	free(state);
	rve_model_free(model);
	return status;
}

/* An RVE file: where it comes from, what has become of it. */
static int print_rve(const char *path, const struct rve_file *file, const struct rve_model *model)
{
	struct rve_info info;
	const struct rve_origin *origin = &file->origin;
	rve_get_info(model, file->state, &info);
	printf("RVE            %s, %d discs%s%s%s%s\n", path, rve_discs(model), *origin->law ? ", law " : "", origin->law,
		   *origin->name ? ", inspected as " : "", origin->name);
	if (origin->point >= 0)
		printf("of             point %lld, step %lld, t = %.9g s\n", origin->point, origin->step, origin->time);
	printf("cell           H = [%.9g %.9g; %.9g %.9g] m\n", info.H[0], info.H[1], info.H[2], info.H[3]);
	printf("void ratio     %.6f\n", info.void_ratio);
	printf("temperature    %.6g K from the reference of the radii\n", info.temperature);
	if (info.bonds_installed > 0)
		printf("bonds          %d of %d intact\n", info.bonds_intact, info.bonds_installed);
	printf("bits           %016llx (a hash of the whole state)\n", file->hash);
	printf("went through   %lld sub-steps%s%s\n", info.total_sub_steps, info.flags & RVE_GAS ? ", flies now" : "",
		   info.flags & RVE_FROZEN ? ", is frozen now" : "");
	return print_state(model, file->state);
}

static int info_rve(const char *path)
{
	struct rve_file *file;
	struct rve_model *model;
	CHECK(rve_file_read(&file, path));
	int status = rve_file_model(&model, file, &file->params);
	if (status == STATUS_OK) {
		status = print_rve(path, file, model);
		rve_model_free(model);
	}
	rve_file_free(file);
	return status;
}

static int cmd_info(const struct options *o)
{
	struct rve_packing *packing;
	if (o->n_files != 1)
		return usage_error("%d files are named, expected one packing (.h5 or .csv) or RVE file", o->n_files);
	if (rve_file_is(o->files[0]))
		return info_rve(o->files[0]);
	CHECK(rve_packing_read(&packing, o->files[0]));
	int status = print_info(o->files[0], packing);
	rve_packing_free(packing);
	return status;
}

/* ---- dispatch ---- */

static const struct {
	const char *name, *help;
	int verb;
	int (*run)(const struct options *options);
} verbs[] = {
	{"pack", help_pack, VERB_PACK, cmd_pack},
	{"load", help_load, VERB_LOAD, cmd_load},
	{"info", help_info, VERB_INFO, cmd_info},
};

static int run_verb(int k, int argc, char **argv)
{
	struct options o;
	int status = parse(&o, verbs[k].verb, argc, argv);
	if (status == STATUS_OK && o.help) {
		fputs(verbs[k].help, stdout);
		return STATUS_OK;
	}
	bool usage = status != STATUS_OK;
	if (!usage) {
		omp_set_num_threads(1); /* one RVE keeps one core busy */
		status = verbs[k].run(&o);
		usage = status == STATUS_INPUT && strncmp(error_message(), "--", 2) == 0;
	}
	if (status != STATUS_OK)
		fprintf(stderr, "tmdempm rve %s: %s\n", verbs[k].name, error_message());
	if (usage)
		fprintf(stderr, "`tmdempm rve %s --help` lists the options\n", verbs[k].name);
	return status;
}

int cli_rve(int argc, char **argv)
{
	if (argc >= 2)
		for (size_t k = 0; k < sizeof verbs / sizeof *verbs; k++)
			if (strcmp(argv[1], verbs[k].name) == 0)
				return run_verb((int)k, argc - 1, argv + 1);
	bool help =
		argc >= 2 && (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0 || strcmp(argv[1], "help") == 0);
	if (!help && argc >= 2)
		fprintf(stderr, "tmdempm rve: unknown verb \"%s\"\n", argv[1]);
	fputs(help_rve, help ? stdout : stderr);
	return help ? STATUS_OK : STATUS_INPUT;
}
