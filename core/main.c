/* The command line. */
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "exact/exact.h"
#include "io/h5.h"
#include "run/bench.h"
#include "run/doctor.h"
#include "run/fragments_cli.h"
#include "run/live.h"
#include "run/look_cli.h"
#include "run/run.h"
#include "run/steer_cli.h"
#include "rve/cli.h"
#include "rve/pool.h"
#include "study/study.h"
#include "version.h"

enum { SETS_MOST = 256, PIPELINES_MOST = 32 };

static const char help[] =
	"tmdempm " TMDEMPM_VERSION ": material points with a discrete RVE behind each\n"
	"\n"
	"  tmdempm run SCENE.cfg [--out DIR] [--force] [--set path=value]... [--threads N] [--device auto|cpu|cuda[:N]|opencl[:N][,...]]\n"
	"                        [--restart FILE [--allow-path-change]] [--until T] [--quiet]\n"
	"                        [--live [PORT|HOST:PORT]] [--pipeline FILE.py]... [--steering FILE.csv] [--paused]\n"
	"      runs a scene; its output goes to DIR (default: SCENE.out here); a DIR that is not empty is refused,\n"
	"      --force moves it aside; --restart continues a checkpoint in its own folder, bit for bit;\n"
	"      with --allow-path-change RVEs of another path are converted: a restart on serial, simd or single as the scene or\n"
	"      --device asks, in other bits from then on;\n"
	"      --live shows the run to a ParaView that listens (default 127.0.0.1:22222), which may come and go;\n"
	"      --pipeline runs a script of ParaView Catalyst, whose files go to DIR/catalyst;\n"
	"      --steering repeats what steered another run (its steering.csv); --paused waits for `steer` before the first "
	"step\n"
	"  tmdempm steer DIR [COMMAND... | -]\n"
	"      steers the run that works in DIR: pause, step, save, stop, inspect, pictures; alone it says how the run "
	"stands\n"
	"      (tmdempm steer --help)\n"
	"  tmdempm check SCENE.cfg [--set path=value]... [--threads N] [--device ...]\n"
	"      validates a scene and says what its run will be; writes nothing\n"
	"  tmdempm info [--json]\n"
	"      what is built in, what is missing and how to get it\n"
	"  tmdempm doctor [--timeout S] [PART]...\n"
	"      tries everything that a run may need here (HDF5, drawing, ParaView, CUDA ...) and says what to do where it\n"
	"      does not work; a part that does not answer within S seconds (30) counts as broken\n"
	"  tmdempm rve pack|load|info|show|extract ...\n"
	"      makes packings, loads one RVE alone; looks into the RVEs of a run, takes one out (tmdempm rve --help)\n"
	"  tmdempm fragments RUN_FOLDER [--time T] [--out FOLDER]\n"
	"      pieces and cracks of what has broken: tables, distribution, lines\n"
	"  tmdempm exact [NAME [--set parameter=value]... --at x,y --times a,b,c|from:to:n]\n"
	"      exact solutions: what there is, or values as CSV\n"
	"  tmdempm study FILE.cfg... [--out DIR] [--jobs N] [--set path=value]... [--fresh] [--no-charts] [--list]\n"
	"      runs studies: many settings of a scene, their errors against their cost; each goes to a folder of its own\n"
	"      below DIR (default: study.out here); what is done is not repeated unless it is --fresh; --list only says\n"
	"      what would be run; tmdempm study --keys explains the file\n"
	"  tmdempm bench rve|mpm|image [--json]\n"
	"      measures this machine\n"
	"  tmdempm --help | --version\n"
	"\n"
	"Lists are addressed by index: --set 'walls.[2].friction=0.3'.\n"
	"SIGINT and SIGTERM finish the step, save and leave; SIGUSR1 saves a checkpoint and goes on.\n"
	"Exit codes: 0 done, 2 bad usage or input, 3 stopped by a stability guard (checkpoint saved), or a study's gate "
	"missed,\n"
	"4 resource or I/O error, 130 interrupted (checkpoint saved).\n";

static int usage(const char *format, const char *what)
{
	char text[512];
	snprintf(text, sizeof text, format, what);
	return error_set(STATUS_INPUT, "%s (see tmdempm --help)", text);
}

/* getopt_long() has met an option that it does not know, or one without its argument. */
static int usage_option(const char *command, int result, char *const *argv)
{
	char text[512];
	const char *word = argv[optind - 1];
	if (result == ':' || !strncmp(word, "--", 2))
		snprintf(text, sizeof text, "%s: %s `%.200s`", command,
				 result == ':' ? "an argument is missing after"
				 : optopt      ? "no argument is expected in"
							   : "unknown option",
				 word);
	else
		snprintf(text, sizeof text, "%s: unknown option `-%c`", command, optopt);
	return usage("%s", text);
}

static int parse_count(int *count, const char *option, const char *text)
{
	char *end;
	long n = strtol(text, &end, 10);
	if (*end || end == text || n < 1 || n > 4096)
		return error_set(STATUS_INPUT, "%s %s: expected a whole number, 1 .. 4096", option, text);
	*count = (int)n;
	return STATUS_OK;
}

static int parse_time(double *time, const char *text)
{
	char *end;
	*time = strtod(text, &end);
	if (*end || end == text || !isfinite(*time) || *time < 0)
		return usage("--until %s: expected a time in seconds, at least 0", text);
	return STATUS_OK;
}

static int parse_set(const char **sets, int *n, const char *text)
{
	if (!strchr(text, '=') || text[0] == '=')
		return usage("--set %s: expected path=value", text);
	if (*n == SETS_MOST)
		return usage("%s", "too many --set options");
	sets[(*n)++] = text;
	return STATUS_OK;
}

/* The argument of --live is optional: the next word is it if it reads like one. */
static const char *take_address(int argc, char **argv)
{
	char host[SCENE_NAME];
	int port;
	if (optarg)
		return optarg;
	if (optind < argc && live_address(argv[optind], host, &port) == STATUS_OK)
		return argv[optind++];
	return "";
}

static int parse_pipeline(const char **pipelines, int *n, const char *text)
{
	if (*n == PIPELINES_MOST)
		return usage("%s", "too many --pipeline options");
	pipelines[(*n)++] = text;
	return STATUS_OK;
}

static int take_scene(const char *command, int argc, char **argv, const char **scene)
{
	if (optind == argc)
		return error_set(STATUS_INPUT, "%s: which scene? expected tmdempm %s SCENE.cfg", command, command);
	if (optind + 1 < argc)
		return usage("one scene at a time: `%s` is too much", argv[optind + 1]);
	*scene = argv[optind];
	return STATUS_OK;
}

static int command_run(int argc, char **argv)
{
	static const struct option long_options[] = {{"out", required_argument, NULL, 'o'},
												 {"force", no_argument, NULL, 'f'},
												 {"set", required_argument, NULL, 's'},
												 {"threads", required_argument, NULL, 't'},
												 {"device", required_argument, NULL, 'd'},
												 {"restart", required_argument, NULL, 'r'},
												 {"until", required_argument, NULL, 'u'},
												 {"quiet", no_argument, NULL, 'q'},
												 {"help", no_argument, NULL, 'h'},
												 {"allow-path-change", no_argument, NULL, 'p'},
												 {"steering", required_argument, NULL, 'g'},
												 {"paused", no_argument, NULL, 'w'},
												 {"live", optional_argument, NULL, 'l'},
												 {"pipeline", required_argument, NULL, 'y'},
												 {NULL, 0, NULL, 0}};
	const char *sets[SETS_MOST], *pipelines[PIPELINES_MOST];
	struct run_options options = {.sets = sets, .pipelines = pipelines, .until = NAN, .device = "cpu"};
	for (int c; (c = getopt_long(argc, argv, ":", long_options, NULL)) != -1;) {
		switch (c) {
		case 'o':
			options.out = optarg;
			break;
		case 'f':
			options.force = true;
			break;
		case 's':
			CHECK(parse_set(sets, &options.n_sets, optarg));
			break;
		case 't':
			CHECK(parse_count(&options.threads, "--threads", optarg));
			break;
		case 'd':
			CHECK(rve_devices_check(optarg));
			options.device = optarg;
			break;
		case 'r':
			options.restart = optarg;
			break;
		case 'u':
			CHECK(parse_time(&options.until, optarg));
			break;
		case 'q':
			options.quiet = true;
			break;
		case 'p':
			options.allow_path_change = true;
			break;
		case 'l':
			options.live = take_address(argc, argv);
			break;
		case 'y':
			CHECK(parse_pipeline(pipelines, &options.n_pipelines, optarg));
			break;
		case 'g':
			options.steering = optarg;
			break;
		case 'w':
			options.paused = true;
			break;
		case 'h':
			fputs(help, stdout);
			return STATUS_OK;
		default:
			return usage_option("run", c, argv);
		}
	}
	CHECK(take_scene("run", argc, argv, &options.scene_path));
	return run_scene(&options);
}

static int command_check(int argc, char **argv)
{
	static const struct option long_options[] = {{"set", required_argument, NULL, 's'},
												 {"threads", required_argument, NULL, 't'},
												 {"device", required_argument, NULL, 'd'},
												 {"help", no_argument, NULL, 'h'},
												 {NULL, 0, NULL, 0}};
	const char *sets[SETS_MOST], *scene = NULL, *device = "cpu";
	int n_sets = 0, threads = 0;
	for (int c; (c = getopt_long(argc, argv, ":", long_options, NULL)) != -1;) {
		if (c == 's')
			CHECK(parse_set(sets, &n_sets, optarg));
		else if (c == 't')
			CHECK(parse_count(&threads, "--threads", optarg));
		else if (c == 'd')
			CHECK(rve_devices_check(device = optarg));
		else if (c == 'h')
			return fputs(help, stdout), STATUS_OK;
		else
			return usage_option("check", c, argv);
	}
	CHECK(take_scene("check", argc, argv, &scene));
	return run_check(scene, n_sets, sets, threads, device);
}

static int command_study(int argc, char **argv)
{
	static const struct option long_options[] = {{"out", required_argument, NULL, 'o'},
												 {"jobs", required_argument, NULL, 'j'},
												 {"set", required_argument, NULL, 's'},
												 {"fresh", no_argument, NULL, 'f'},
												 {"no-charts", no_argument, NULL, 'n'},
												 {"list", no_argument, NULL, 'l'},
												 {"keys", no_argument, NULL, 'k'},
												 {"help", no_argument, NULL, 'h'},
												 {NULL, 0, NULL, 0}};
	const char *sets[SETS_MOST];
	struct study_options options = {.out = "study.out", .jobs = 1, .sets = sets};
	for (int c; (c = getopt_long(argc, argv, ":", long_options, NULL)) != -1;) {
		switch (c) {
		case 'o':
			options.out = optarg;
			break;
		case 'j':
			CHECK(parse_count(&options.jobs, "--jobs", optarg));
			break;
		case 's':
			CHECK(parse_set(sets, &options.n_sets, optarg));
			break;
		case 'f':
			options.fresh = true;
			break;
		case 'n':
			options.no_charts = true;
			break;
		case 'l':
			options.list = true;
			break;
		case 'k':
			return study_print_keys(stdout), STATUS_OK;
		case 'h':
			return fputs(help, stdout), STATUS_OK;
		default:
			return usage_option("study", c, argv);
		}
	}
	if (optind == argc)
		return usage("%s", "study: which study? expected tmdempm study FILE.cfg...");
	return study_run(argc - optind, argv + optind, &options);
}

/* Commands whose only option is --json; *word is their one argument, or NULL. */
static int parse_json(int argc, char **argv, const char *command, bool *json, bool *helped)
{
	static const struct option long_options[] = {
		{"json", no_argument, NULL, 'j'}, {"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0}};
	*json = *helped = false;
	for (int c; (c = getopt_long(argc, argv, ":", long_options, NULL)) != -1;) {
		if (c == 'j')
			*json = true;
		else if (c == 'h')
			*helped = true;
		else
			return usage_option(command, c, argv);
	}
	if (*helped)
		fputs(help, stdout);
	return STATUS_OK;
}

static int command_info(int argc, char **argv)
{
	bool json, helped;
	CHECK(parse_json(argc, argv, "info", &json, &helped));
	if (optind < argc)
		return usage("info: `%s` is too much", argv[optind]);
	return helped ? STATUS_OK : run_info(json);
}

static int command_doctor(int argc, char **argv)
{
	static const struct option long_options[] = {
		{"timeout", required_argument, NULL, 't'}, {"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0}};
	double timeout = 30.0;
	for (int c; (c = getopt_long(argc, argv, ":", long_options, NULL)) != -1;) {
		char *end = NULL;
		if (c == 'h')
			return fputs(help, stdout), STATUS_OK;
		if (c != 't')
			return usage_option("doctor", c, argv);
		timeout = strtod(optarg, &end);
		if (*end || end == optarg || !(timeout > 0) || timeout > 3600)
			return usage("doctor: --timeout %s: expected seconds, above 0 and at most 3600", optarg);
	}
	return run_doctor(timeout, argc - optind, argv + optind);
}

static int command_bench(int argc, char **argv)
{
	bool json, helped;
	CHECK(parse_json(argc, argv, "bench", &json, &helped));
	if (helped)
		return STATUS_OK;
	const char *what = optind + 1 == argc ? argv[optind] : "";
	if (!strcmp(what, "rve"))
		return bench_rve(json);
	if (!strcmp(what, "mpm"))
		return bench_mpm(json);
	if (!strcmp(what, "image"))
		return bench_image(json);
	return usage("%s", "bench: expected one of rve, mpm, image");
}

int main(int argc, char **argv)
{
	static const struct {
		const char *name;
		int (*command)(int argc, char **argv);
	} commands[] = {{"run", command_run},         {"check", command_check}, {"info", command_info},
					{"bench", command_bench},     {"study", command_study}, {"exact", cli_exact},
					{"fragments", cli_fragments}, {"steer", cli_steer},     {"doctor", command_doctor}};
	h5_start();
	const char *name = argc > 1 ? argv[1] : "";
	if (!strcmp(name, "--help") || !strcmp(name, "-h") || !strcmp(name, "help"))
		return fputs(help, stdout), STATUS_OK;
	if (!strcmp(name, "--version"))
		return printf("tmdempm %s\n", TMDEMPM_VERSION), STATUS_OK;
	if (!strcmp(name, "rve") && argc > 2 && cli_look_has(argv[2]))
		return cli_look(argc - 2, argv + 2);
	if (!strcmp(name, "rve"))
		return cli_rve(argc - 1, argv + 1);
	int status =
		*name
			? usage(
				  "`%s` is no command: expected run, steer, check, info, doctor, rve, fragments, exact, study or bench",
				  name)
			: usage("%s",
					"which command? expected run, steer, check, info, doctor, rve, fragments, exact, study or bench");
	for (size_t i = 0; i < sizeof commands / sizeof *commands; i++)
		if (!strcmp(name, commands[i].name))
			status = commands[i].command(argc - 1, argv + 1);
	if ((fflush(stdout) != 0 || ferror(stdout)) && status == STATUS_OK)
		status = error_set(STATUS_RESOURCE, "cannot write to the standard output");
	if (status != STATUS_OK && error_message()[0])
		fprintf(stderr, "tmdempm: %s\n", error_message());
	return status;
}
