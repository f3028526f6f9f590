#include "run/machine.h"

#include <omp.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* The words of `flags` that `wanted` names, in that order. */
static void machine_isa(char *isa, size_t size, const char *flags)
{
	static const char *const wanted[] = {"sse4_2", "avx", "avx2", "fma", "avx512f", "asimd", "sve"};
	size_t n = 0;
	isa[0] = '\0';
	for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
		char word[16];
		snprintf(word, sizeof word, " %s ", wanted[i]);
		if (strstr(flags, word))
			n += (size_t)snprintf(isa + n, size - n, "%s%s", n ? " " : "", wanted[i]);
	}
}

void machine_look(struct machine *machine)
{
	memset(machine, 0, sizeof *machine);
	snprintf(machine->processor, sizeof machine->processor, "unknown processor");
	machine->threads = omp_get_max_threads();
	machine->memory = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
	FILE *stream = fopen("/proc/cpuinfo", "re");
	char line[8192];
	while (stream && fgets(line, sizeof line, stream) &&
		   !(machine->isa[0] && strncmp(machine->processor, "unknown", 7))) {
		char *value = strchr(line, ':');
		if (!value)
			continue;
		line[strcspn(line, "\n")] = ' ';
		if (!strncmp(line, "model name", 10))
			snprintf(machine->processor, sizeof machine->processor, "%.*s", (int)strlen(value) - 3, value + 2);
		if (!strncmp(line, "flags", 5) || !strncmp(line, "Features", 8))
			machine_isa(machine->isa, sizeof machine->isa, value);
	}
	if (stream)
		fclose(stream);
}
