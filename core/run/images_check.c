#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "base/ticks.h"
#include "run/run_private.h"

/* What every frame carries beside the tables. */
static const struct field frame_fields[] = {{"material", "-", 1, ""}, {"id", "-", 1, ""}};

/* A field by its name, among the points' own and those of the laws that this scene uses. */
static const struct field *find_field(const struct scene *scene, const char *name)
{
	for (int f = 0; f < particle_fields_count; f++)
		if (particle_field_applies(scene, f) && !strcmp(particle_fields[f].name, name))
			return &particle_fields[f];
	for (int k = 0; k < scene->n_laws; k++) {
		const struct law_type *type = law_type_of(&scene->laws[k]);
		for (int f = 0; type && f < type->n_fields; f++)
			if (!strcmp(type->fields[f].name, name))
				return &type->fields[f];
	}
	for (size_t f = 0; f < sizeof frame_fields / sizeof *frame_fields; f++)
		if (!strcmp(frame_fields[f].name, name))
			return &frame_fields[f];
	return NULL;
}

static void print_names(const struct scene *scene, FILE *errors)
{
	for (int f = 0; f < particle_fields_count; f++)
		if (particle_field_applies(scene, f))
			fprintf(errors, "%s%s", f ? ", " : "", particle_fields[f].name);
	for (const struct law_type *const *type = law_types; *type; type++) {
		bool used = false;
		for (int k = 0; k < scene->n_laws; k++)
			used |= law_type_of(&scene->laws[k]) == *type;
		for (int f = 0; used && f < (*type)->n_fields; f++)
			fprintf(errors, ", %s", (*type)->fields[f].name);
	}
}

/* Can the picture show the field in the unit that it asks for?  Temperatures come in the scene's unit only. */
static bool unit_fits(const struct scene *scene, const struct field *field, const char *unit)
{
	if (!unit[0])
		return true;
	return strcmp(field->unit, "T") ? ticks_unit_factor(field->unit, unit) > 0.0
									: !strcmp(unit, scene_temperature_unit(scene));
}

static void print_component(FILE *errors, const char *name, int tensor)
{
	fprintf(errors, ".component is no component of the %s %s, expected %s\n",
			tensor == 4   ? "tensor"
			: tensor == 2 ? "vector"
						  : "scalar",
			name,
			tensor == 4   ? "magnitude, xx, yy, zz or xy"
			: tensor == 2 ? "magnitude, x or y"
						  : "magnitude");
}

/* What is wrong with a picture of points goes to `errors`; the number of mistakes. */
static int image_check(const struct scene *scene, int i, FILE *errors)
{
	const struct scene_image *image = &scene->images[i];
	const struct field *field = find_field(scene, image->field);
	int tensor = field && field->components == 6 ? 4 : field && field->components == 3 ? 2 : 0;
	bool component = field && (image->component < tensor), unit = field && unit_fits(scene, field, image->unit);
	if (component && unit)
		return 0;
	fprintf(errors, "%s:%d: images.[%d]", image->place.file, image->place.line, i);
	if (!field) {
		fprintf(errors, ".field is \"%s\", expected one of ", image->field);
		print_names(scene, errors);
		fputc('\n', errors);
	} else if (!component) {
		print_component(errors, image->field, tensor);
	} else {
		bool temperature = !strcmp(field->unit, "T");
		fprintf(errors, ".unit is \"%s\", in which %s cannot be shown, expected %s%s\n", image->unit, image->field,
				temperature ? scene_temperature_unit(scene) : field->unit,
				temperature ? ", the scene's unit" : ", with or without an SI prefix where that is usual");
	}
	return 1;
}

int images_check(const struct scene *scene, void *errors)
{
	int wrong = 0;
	for (int i = 0; i < scene->n_images; i++)
		if (scene->images[i].kind != SCENE_IMAGE_RVE) /* checked with the scene */
			wrong += image_check(scene, i, errors);
	return wrong ? error_set(STATUS_INPUT, "%s: %d error%s", scene->path, wrong, wrong == 1 ? "" : "s") : STATUS_OK;
}
