#include "run/fields.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"

static const char *field_unit(const struct mpm *mpm, const struct field *field)
{
	return strcmp(field->unit, "T") ? field->unit : scene_temperature_unit(mpm->scene);
}

int fields_find(const struct run_fields *fields, const char *name)
{
	for (int f = 0; f < fields->n; f++)
		if (!strcmp(fields->fields[f].field->name, name))
			return f;
	return -1;
}

static void fields_add(struct run_fields *fields, const struct mpm *mpm, const struct field *field, int particle)
{
	if (fields_find(fields, field->name) < 0)
		fields->fields[fields->n++] = (struct run_field){field, field_unit(mpm, field), particle};
}

int fields_create(struct run_fields **result, const struct mpm *mpm)
{
	*result = NULL;
	int most = particle_fields_count;
	for (int l = 0; l < mpm->n_laws; l++)
		most += mpm->laws[l]->type->n_fields;
	struct run_fields *fields = calloc(1, sizeof *fields);
	if (!fields)
		return error_set(STATUS_RESOURCE, "out of memory");
	size_t n = (size_t)mpm->p.n + 1;
	fields->fields = calloc((size_t)most + 1, sizeof *fields->fields);
	fields->values = malloc(n * 6 * sizeof *fields->values);
	fields->slots = malloc(n * sizeof *fields->slots);
	fields->points = malloc(n * sizeof *fields->points);
	if (!fields->fields || !fields->values || !fields->slots || !fields->points) {
		fields_free(fields);
		return error_set(STATUS_RESOURCE, "out of memory");
	}
	for (int f = 0; f < particle_fields_count; f++)
		if (particle_field_applies(mpm->scene, f))
			fields_add(fields, mpm, &particle_fields[f], f);
	for (int l = 0; l < mpm->n_laws; l++)
		for (int f = 0; f < mpm->laws[l]->type->n_fields; f++)
			fields_add(fields, mpm, &mpm->laws[l]->type->fields[f], -1);
	*result = fields;
	return STATUS_OK;
}

void fields_free(struct run_fields *fields)
{
	if (!fields)
		return;
	free(fields->fields);
	free(fields->values);
	free(fields->slots);
	free(fields->points);
	free(fields);
}

/* The law's values go to the places of its points. */
static void fields_get_law(struct run_fields *fields, const struct mpm *mpm, int l, int law_field, int components,
						   double *out)
{
	int n = 0;
	for (int p = 0; p < mpm->p.n; p++)
		if (mpm->p.law[p] == l) {
			fields->points[n] = p;
			fields->slots[n++] = mpm->p.slot[p];
		}
	const struct law *law = mpm->laws[l];
	law->type->export_field(law, law_field, n, fields->slots, fields->values);
	for (int k = 0; k < n; k++)
		memcpy(out + (size_t)fields->points[k] * (size_t)components, fields->values + (size_t)k * (size_t)components,
			   (size_t)components * sizeof *out);
}

void fields_get(struct run_fields *fields, const struct mpm *mpm, int f, double *out)
{
	const struct run_field *field = &fields->fields[f];
	int components = field->field->components;
	size_t count = (size_t)mpm->p.n * (size_t)components;
	if (field->particle >= 0) {
		particle_field_get(mpm, field->particle, out);
	} else {
		for (size_t i = 0; i < count; i++)
			out[i] = NAN;
		for (int l = 0; l < mpm->n_laws; l++)
			for (int g = 0; g < mpm->laws[l]->type->n_fields; g++)
				if (!strcmp(mpm->laws[l]->type->fields[g].name, field->field->name) &&
					mpm->laws[l]->type->fields[g].components == components)
					fields_get_law(fields, mpm, l, g, components, out);
	}
	if (!strcmp(field->field->unit, "T"))
		for (size_t i = 0; i < count; i++)
			out[i] = scene_temperature_out(mpm->scene, out[i]);
}

const char *field_component_ending(int components, int c)
{
	static const char *const vector[3] = {"_x", "_y", NULL};
	static const char *const tensor[6] = {"_xx", "_yy", "_zz", "_xy", NULL, NULL};
	return components == 1 ? "" : components == 3 ? vector[c] : tensor[c];
}
