/* Shapes of bodies that stand in files: outlines as tables of corners or VTK polygons, masks as grey images.
 *
 * Images are PGM, because its whole definition is a header of three numbers and the pixels behind it: no library to
 * keep. */
#include <ctype.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/error.h"
#include "scene/custom.h"
#include "scene/private.h"

enum { CORNERS_MOST = 1000000, FILE_MOST = 1 << 30 };

/* The file that a value names, whole, with '\0' behind it; NULL (recorded) if it cannot be read.  The tree keeps the
 * absolute path, so that the scene's text means the same wherever it is stored. */
static char *read_named(struct loader *loader, const struct scene_key *key, struct node *node, const char *path,
						size_t *size)
{
	char absolute[PATH_MAX];
	if (node->type != NODE_STRING) {
		problem_at(loader, node->place, path, "is %s, expected %s", node_kind(node), key->expected);
		return NULL;
	}
	const char *seen = node->place.line > 0 ? path_beside(loader, node->place.file, node->string) : node->string;
	FILE *in = realpath(seen, absolute) ? fopen(absolute, "rb") : NULL;
	if (!in) {
		problem_at(loader, node->place, path, "'%s' cannot be read, expected %s", seen, key->expected);
		return NULL;
	}
	fseek(in, 0, SEEK_END);
	long length = ftell(in);
	rewind(in);
	char *text = length >= 0 && length < FILE_MOST ? loader_alloc(loader, (size_t)length + 1) : NULL;
	*size = text ? fread(text, 1, (size_t)length, in) : 0;
	fclose(in);
	if (!text || *size != (size_t)length) {
		problem_at(loader, node->place, path, "'%s' cannot be read whole, expected %s", seen, key->expected);
		return NULL;
	}
	node->string = loader_string(loader, absolute);
	return text;
}

static bool has_end(const char *name, const char *end)
{
	size_t n = strlen(name), m = strlen(end);
	return n > m && !strcmp(name + n - m, end);
}

/* ---- outlines ---- */

/* Rows x,y; '#' begins a comment, a first row without numbers is a header.  Returns their number, or minus the line
 * that is wrong. */
static int parse_table(char *text, double (*v)[2])
{
	int n = 0, line = 0;
	for (char *row = text, *next; row; row = next) {
		next = strchr(row, '\n');
		if (next)
			*next++ = '\0';
		line++;
		row += strspn(row, " \t\r");
		if (*row == '\0' || *row == '#')
			continue;
		char *middle, *end;
		double x = strtod(row, &middle);
		if (middle == row && n == 0)
			continue;
		middle += strspn(middle, " \t");
		middle += *middle == ',';
		double y = strtod(middle, &end);
		end += strspn(end, " \t\r");
		if (end == middle || *end || !isfinite(x) || !isfinite(y))
			return -line;
		v[n][0] = x, v[n++][1] = y;
	}
	return n;
}

/* Numbers of the ascii DataArray that follows `from` and whose head holds `mark`; their count, -1 = there is none. */
static int parse_array(const char *from, const char *until, const char *mark, double *values, int most)
{
	for (const char *at = from; at && (at = strstr(at, "<DataArray")) && at < until; at++) {
		const char *end = strchr(at, '>');
		const char *found = strstr(at, mark);
		if (!end || !found || found > end)
			continue;
		const char *ascii = strstr(at, "format=\"ascii\"");
		if (!ascii || ascii > end)
			return -1;
		int n = 0;
		for (char *p = (char *)end + 1, *next; n < most; p = next) {
			values[n] = strtod(p, &next);
			if (next == p)
				break;
			n++;
		}
		return n;
	}
	return -1;
}

/* The first cell of Polys, or of Lines; 0 if there is none that can be read. */
static int parse_vtp(const char *text, size_t size, double (*v)[2])
{
	const char *points = strstr(text, "<Points>"), *end = text + size;
	int most = (int)(size / 2) + 3, n = 0;
	double *xyz = malloc((size_t)most * sizeof *xyz), *ids = malloc((size_t)most * sizeof *ids), first;
	int count = points && xyz && ids ? parse_array(points, end, "NumberOfComponents=\"3\"", xyz, most) / 3 : 0;
	static const char *const groups[] = {"<Polys>", "<Lines>"};
	for (int g = 0; g < 2 && n == 0 && count > 0; g++) {
		const char *cells = strstr(text, groups[g]);
		if (!cells || parse_array(cells, end, "Name=\"offsets\"", &first, 1) != 1)
			continue;
		int got = parse_array(cells, end, "Name=\"connectivity\"", ids, most);
		for (int k = 0; k < got && k < (int)first; k++) {
			int id = (int)ids[k];
			if (id < 0 || id >= count) {
				n = 0;
				break;
			}
			v[n][0] = xyz[3 * id], v[n++][1] = xyz[3 * id + 1];
		}
	}
	free(xyz), free(ids);
	return n;
}

void read_body_outline(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
					   const char *path)
{
	struct scene_body *body = target;
	size_t size;
	if (body->n_vertices)
		problem_at(loader, node->place, path, "is a second shape of this body, expected one");
	if (node->type == NODE_STRING && !has_end(node->string, ".csv") && !has_end(node->string, ".vtp")) {
		problem_at(loader, node->place, path, "is \"%s\", expected %s", node->string, key->expected);
		return;
	}
	char *text = read_named(loader, key, node, path, &size);
	if (!text)
		return;
	bool vtp = has_end(node->string, ".vtp");
	double(*v)[2] = scene_alloc(loader, (size / 2 + 3) * sizeof *v);
	int n = vtp ? parse_vtp(text, size, v) : parse_table(text, v);
	if (n < 0) {
		problem_at(loader, node->place, path, "%s:%d: is no row x,y, expected two numbers in m", node->string, -n);
		return;
	}
	if (n > 1 && v[0][0] == v[n - 1][0] && v[0][1] == v[n - 1][1])
		n--; /* closed on itself: a habit of both formats */
	if (n < 3) {
		problem_at(loader, node->place, path, "'%s' holds %d corners, expected at least 3%s", node->string, n,
				   vtp ? " of a cell of Polys or Lines, ascii" : ", one x,y a row");
		return;
	}
	body->n_vertices = n, body->vertices = v;
}

/* ---- masks ---- */

/* The next number of a PGM's head, which comments may stand between; -1 = there is none. */
static long head_number(const char **at, const char *end)
{
	while (*at < end && (isspace((unsigned char)**at) || **at == '#')) {
		if (**at == '#')
			while (*at < end && **at != '\n')
				++*at;
		else
			++*at;
	}
	char *next;
	long value = *at < end ? strtol(*at, &next, 10) : -1;
	if (*at >= end || next == *at)
		return -1;
	*at = next;
	return value;
}

void read_mask_file(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
					const char *path)
{
	struct scene_mask *mask = target;
	size_t size;
	char *text = read_named(loader, key, node, path, &size);
	if (!text)
		return;
	const char *at = text + 2, *end = text + size;
	bool plain = size > 2 && text[0] == 'P' && text[1] == '2', raw = size > 2 && text[0] == 'P' && text[1] == '5';
	long nx = plain || raw ? head_number(&at, end) : -1, ny = head_number(&at, end), most = head_number(&at, end);
	if (nx < 1 || ny < 1 || nx > CORNERS_MOST || ny > CORNERS_MOST || nx * ny > FILE_MOST || most < 1 || most > 255) {
		problem_at(loader, node->place, path, "'%s' is no grey image, expected a PGM (P2 or P5) of values up to 255",
				   node->string);
		return;
	}
	unsigned char *grey = scene_alloc(loader, (size_t)(nx * ny));
	at += raw; /* one white character ends the head */
	bool whole = !raw || end - at >= nx * ny;
	for (long j = ny - 1; j >= 0 && whole; j--) /* rows come from the top */
		for (long i = 0; i < nx && whole; i++) {
			long value = raw ? (long)(unsigned char)*at++ : head_number(&at, end);
			whole = value >= 0 && value <= most;
			grey[j * nx + i] = (unsigned char)(value * 255 / most);
		}
	if (!whole) {
		problem_at(loader, node->place, path, "'%s' ends early, expected %ld x %ld pixels", node->string, nx, ny);
		return;
	}
	snprintf(mask->file, sizeof mask->file, "%s", node->string);
	mask->nx = (int)nx, mask->ny = (int)ny, mask->inside = grey;
}
