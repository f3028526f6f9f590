#include "law/law.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"

extern const struct law_type law_thermoelastic, law_rve, law_neohookean_rankine;

const struct law_type *const law_types[] = {&law_thermoelastic, &law_rve, &law_neohookean_rankine, NULL};

const struct law_type *law_type_of(const struct scene_law *scene)
{
	const char *name = scene_law_type_names[scene->type];
	for (int i = 0; law_types[i]; i++)
		if (!strcmp(law_types[i]->name, name))
			return law_types[i];
	return NULL;
}

int law_allocate(struct law *law, size_t model_bytes, size_t state_bytes)
{
	size_t bytes = ((size_t)law->n_points * state_bytes + 63) / 64 * 64 + 64;
	law->state_bytes = state_bytes;
	law->model = calloc(1, model_bytes);
	law->states = aligned_alloc(64, bytes);
	if (!law->model || !law->states)
		return error_set(STATUS_RESOURCE, "out of memory for %d points of law '%s'", law->n_points, law->name);
	memset(law->states, 0, bytes);
	return STATUS_OK;
}

void law_release(struct law *law)
{
	free(law->model);
	free(law->states);
}

int law_create(struct law **result, const struct scene_law *scene, int n_points, const int *variant)
{
	*result = NULL;
	const struct law_type *type = law_type_of(scene);
	if (!type)
		return error_set(STATUS_INPUT, "law '%s': this build does not have its type", scene->name);
	struct law *law = calloc(1, sizeof *law);
	if (!law)
		return error_set(STATUS_RESOURCE, "out of memory for law '%s'", scene->name);
	law->type = type;
	law->scene = scene;
	law->n_points = n_points;
	law->density = NAN;
	law->coupling = 1.0;
	memcpy(law->name, scene->name, sizeof law->name);
	int status = type->create(law, scene, n_points, variant);
	if (status == STATUS_OK)
		*result = law;
	else
		law_free(law);
	return status;
}

void law_free(struct law *law)
{
	if (!law)
		return;
	law->type->destroy(law);
	free(law);
}
