#include "mpm/particles.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/mat2.h"
#include "mpm/mpm_private.h"

/* One table drives allocation, sorting and the checkpoint. */
struct column {
	const char *name;
	size_t offset; /* of the pointer in struct particles */
	char type;     /* as in struct mpm_state_array */
	int per_point;
};

#define COLUMN(member, type, per_point)                                                                                \
	{                                                                                                                  \
		"points/" #member, offsetof(struct particles, member), type, per_point                                         \
	}

static const struct column columns[] = {
	COLUMN(id, 'i', 1),
	COLUMN(body, 'i', 1),
	COLUMN(material, 'i', 1),
	COLUMN(law, 'i', 1),
	COLUMN(slot, 'i', 1),
	COLUMN(x, 'd', 2),
	COLUMN(x0, 'd', 2),
	COLUMN(v, 'd', 2),
	COLUMN(F, 'd', 4),
	COLUMN(L, 'd', 4),
	COLUMN(mass, 'd', 1),
	COLUMN(volume0, 'd', 1),
	COLUMN(stress, 'd', 4),
	COLUMN(modulus, 'd', 1),
	COLUMN(T, 'd', 1),
	COLUMN(T_smooth, 'd', 1),
	COLUMN(dT, 'd', 1),
	COLUMN(heat, 'd', 1),
	COLUMN(conductivity, 'd', 3),
	COLUMN(capacity, 'd', 1),
	COLUMN(thawed, 'd', 1),
	COLUMN(heat_pending, 'd', 1),
	COLUMN(heat_friction_sum, 'd', 1),
	COLUMN(growth, 'd', 1),
	COLUMN(affine, 'd', 4),           /* with APIC only */
	COLUMN(damage, 'd', 1),           /* with a law that breaks only */
	COLUMN(contact_pressure, 'd', 1), /* with contacts or penalty walls only */
	COLUMN(damage_gradient, 'd', 2),  /* with contacts and a law that breaks only */
};

enum { N_COLUMNS = sizeof columns / sizeof *columns };

static size_t column_bytes(const struct column *column)
{
	return (size_t)column->per_point * (column->type == 'i' ? sizeof(int) : sizeof(double));
}

static void *column_of(const struct particles *p, const struct column *column)
{
	return *(void *const *)((const char *)p + column->offset);
}

/* Rounded up to whole cache lines, as aligned_alloc wants it. */
static size_t padded(size_t bytes) { return (bytes + 63) / 64 * 64; }

int particles_create(struct particles *p, int n, bool affine, bool damage, bool contacts, bool pressure)
{
	memset(p, 0, sizeof *p);
	p->n = n;
	for (int c = 0; c < N_COLUMNS; c++) {
		if ((columns[c].offset == offsetof(struct particles, affine) && !affine) ||
			(columns[c].offset == offsetof(struct particles, damage) && !damage) ||
			(columns[c].offset == offsetof(struct particles, contact_pressure) && !pressure) ||
			(columns[c].offset == offsetof(struct particles, damage_gradient) && !(contacts && damage)))
			continue;
		size_t bytes = padded((size_t)n * column_bytes(&columns[c]) + 1);
		void *data = aligned_alloc(64, bytes);
		if (!data) {
			particles_free(p);
			return error_set(STATUS_RESOURCE, "out of memory for %d points", n);
		}
		memset(data, 0, bytes);
		*(void **)((char *)p + columns[c].offset) = data;
	}
	return STATUS_OK;
}

void particles_free(struct particles *p)
{
	for (int c = 0; c < N_COLUMNS; c++)
		free(column_of(p, &columns[c]));
	memset(p, 0, sizeof *p);
}

size_t particles_bytes(const struct particles *p)
{
	size_t bytes = 0;
	for (int c = 0; c < N_COLUMNS; c++)
		if (column_of(p, &columns[c]))
			bytes += padded((size_t)p->n * column_bytes(&columns[c]) + 1);
	return bytes;
}

size_t particles_widest(void)
{
	size_t widest = 0;
	for (int c = 0; c < N_COLUMNS; c++)
		widest = column_bytes(&columns[c]) > widest ? column_bytes(&columns[c]) : widest;
	return widest;
}

void particles_permute(struct particles *p, const int *permutation, void *scratch)
{
	for (int c = 0; c < N_COLUMNS; c++) {
		size_t bytes = column_bytes(&columns[c]);
		char *data = column_of(p, &columns[c]), *copy = scratch;
		if (!data)
			continue;
		memcpy(copy, data, (size_t)p->n * bytes);
		for (int k = 0; k < p->n; k++)
			memcpy(data + (size_t)k * bytes, copy + (size_t)permutation[k] * bytes, bytes);
	}
}

int particles_state(struct particles *p, struct mpm_state_array *arrays, int at)
{
	for (int c = 0; c < N_COLUMNS; c++) {
		void *data = column_of(p, &columns[c]);
		if (data && arrays)
			arrays[at] = (struct mpm_state_array){columns[c].name, data, columns[c].type,
												  (size_t)p->n * (size_t)columns[c].per_point};
		at += data != NULL;
	}
	return at;
}

void point_stop(struct particles *p, int k)
{
	memset(p->v[k], 0, sizeof p->v[k]);
	if (p->affine)
		memset(p->affine[k], 0, sizeof p->affine[k]);
}

/* ---- fields for viewers and files ---- */

enum particle_field {
	FIELD_VELOCITY,
	FIELD_DISPLACEMENT,
	FIELD_STRESS,
	FIELD_PRESSURE,
	FIELD_STRESS_DEVIATORIC,
	FIELD_STRAIN,
	FIELD_STRAIN_VOLUMETRIC,
	FIELD_STRAIN_DEVIATORIC,
	FIELD_STRAIN_RATE,
	FIELD_TEMPERATURE,
	FIELD_TEMPERATURE_SMOOTH,
	FIELD_HEAT_SOURCE,
	FIELD_HEAT_FRICTION,
	FIELD_CONDUCTIVITY,
	FIELD_THAWED,
	FIELD_DENSITY,
	FIELD_VOLUME,
	FIELD_MASS,
	FIELD_MODULUS,
	FIELD_BODY,
	FIELD_CONTACT_PRESSURE
};

const struct field particle_fields[] = {
	[FIELD_VELOCITY] = {"velocity", "m/s", 3, "velocity"},
	[FIELD_DISPLACEMENT] = {"displacement", "m", 3, "way since birth"},
	[FIELD_STRESS] = {"stress", "Pa", 6, "Cauchy stress, tension positive"},
	[FIELD_PRESSURE] = {"pressure", "Pa", 1, "minus half the trace of the in-plane stress"},
	[FIELD_STRESS_DEVIATORIC] = {"stress_deviatoric", "Pa", 1,
								 "half the difference of the in-plane principal stresses"},
	[FIELD_STRAIN] = {"strain", "-", 6, "Hencky strain ln U of the accumulated deformation"},
	[FIELD_STRAIN_VOLUMETRIC] = {"strain_volumetric", "-", 1, "ln det F"},
	[FIELD_STRAIN_DEVIATORIC] = {"strain_deviatoric", "-", 1, "sqrt(2/3 e':e') of the Hencky strain"},
	[FIELD_STRAIN_RATE] = {"strain_rate", "1/s", 1, "sqrt(2/3 d':d') of the rate of deformation"},
	[FIELD_TEMPERATURE] = {"temperature", "T", 1, "temperature"},
	[FIELD_TEMPERATURE_SMOOTH] = {"temperature_smooth", "T", 1, "remapped temperature, as the law sees it"},
	[FIELD_HEAT_SOURCE] = {"heat_source", "W/m3", 1, "heat source of the law in the last step"},
	[FIELD_HEAT_FRICTION] = {"heat_friction", "J/m3", 1, "heat received from the law so far, per initial volume"},
	[FIELD_CONDUCTIVITY] = {"conductivity", "W/(m K)", 6,
							"conductivity tensor; zz is 0 where a law knows the plane only"},
	[FIELD_THAWED] = {"thawed_fraction", "-", 1, "share of the mass that is not frozen; only where something freezes"},
	[FIELD_DENSITY] = {"density", "kg/m3", 1, "bulk density"},
	[FIELD_VOLUME] = {"volume", "m3", 1, "volume, with the grid's thickness"},
	[FIELD_MASS] = {"mass", "kg", 1, "mass, with the grid's thickness"},
	[FIELD_MODULUS] = {"modulus", "Pa", 1, "P-wave modulus"},
	[FIELD_BODY] = {"body", "-", 1, "number of the body in the scene"},
	[FIELD_CONTACT_PRESSURE] = {"contact_pressure", "Pa", 1,
								"from other bodies and penalty walls in the last step, at points near a contact; only with such"},
};
const int particle_fields_count = sizeof particle_fields / sizeof *particle_fields;

bool particle_field_applies(const struct scene *scene, int f)
{
	bool applies = f != FIELD_THAWED;
	if (f == FIELD_CONTACT_PRESSURE)
		return scene_presses(scene);
	for (int m = 0; m < scene->n_materials; m++)
		applies = applies || !isnan(scene->materials[m].freezing[0]);
	return applies;
}

/* sqrt(2/3 e':e') with e' = e - tr(e)/2 I, in the plane. */
static double deviatoric(double xx, double yy, double xy)
{
	double d = 0.5 * (xx - yy);
	return sqrt(2.0 / 3.0 * (2.0 * d * d + 2.0 * xy * xy));
}

static void tensor(double out[6], double xx, double yy, double zz, double xy)
{
	out[0] = xx, out[1] = yy, out[2] = zz, out[3] = xy, out[4] = 0.0, out[5] = 0.0;
}

static void strain_field(int f, const double F[4], double *out)
{
	double e[3];
	mat2_log_stretch(F, e);
	if (f == FIELD_STRAIN)
		tensor(out, e[0], e[1], 0.0, e[2]);
	else
		*out = f == FIELD_STRAIN_VOLUMETRIC ? e[0] + e[1] : deviatoric(e[0], e[1], e[2]);
}

static void stress_field(int f, const double s[4], double *out)
{
	if (f == FIELD_STRESS)
		tensor(out, s[0], s[1], s[2], s[3]);
	else
		*out = f == FIELD_PRESSURE ? -0.5 * (s[0] + s[1]) : hypot(0.5 * (s[0] - s[1]), s[3]);
}

static void conductivity_field(const struct mpm *mpm, int k, double out[6])
{
	double c[3];
	mpm_point_conductivity(mpm, k, c);
	tensor(out, c[0], c[1], isnan(mpm_work(mpm)->conductivity[mpm->p.material[k]]) ? 0.0 : c[0], c[2]);
}

static void point_field(const struct mpm *mpm, int f, int k, double *out)
{
	const struct particles *p = &mpm->p;
	switch (f) {
	case FIELD_VELOCITY:
		out[0] = p->v[k][0], out[1] = p->v[k][1], out[2] = 0.0;
		break;
	case FIELD_DISPLACEMENT:
		out[0] = p->x[k][0] - p->x0[k][0], out[1] = p->x[k][1] - p->x0[k][1], out[2] = 0.0;
		break;
	case FIELD_STRESS:
	case FIELD_PRESSURE:
	case FIELD_STRESS_DEVIATORIC:
		stress_field(f, p->stress[k], out);
		break;
	case FIELD_STRAIN:
	case FIELD_STRAIN_VOLUMETRIC:
	case FIELD_STRAIN_DEVIATORIC:
		strain_field(f, p->F[k], out);
		break;
	case FIELD_STRAIN_RATE:
		*out = deviatoric(p->L[k][0], p->L[k][3], 0.5 * (p->L[k][1] + p->L[k][2]));
		break;
	case FIELD_TEMPERATURE:
		*out = p->T[k];
		break;
	case FIELD_TEMPERATURE_SMOOTH:
		*out = p->T_smooth[k];
		break;
	case FIELD_HEAT_SOURCE:
		*out = p->heat[k];
		break;
	case FIELD_HEAT_FRICTION:
		*out = p->heat_friction_sum[k];
		break;
	case FIELD_CONDUCTIVITY:
		conductivity_field(mpm, k, out);
		break;
	case FIELD_THAWED:
		*out = p->thawed[k];
		break;
	case FIELD_DENSITY:
		*out = p->mass[k] / (p->volume0[k] * mat2_determinant(p->F[k]));
		break;
	case FIELD_VOLUME:
		*out = p->volume0[k] * mat2_determinant(p->F[k]);
		break;
	case FIELD_MASS:
		*out = p->mass[k];
		break;
	case FIELD_MODULUS:
		*out = p->modulus[k];
		break;
	case FIELD_BODY:
		*out = p->body[k];
		break;
	case FIELD_CONTACT_PRESSURE:
		*out = p->contact_pressure[k];
		break;
	}
}

void particle_field_get(const struct mpm *mpm, int f, double *out)
{
	for (int k = 0; k < mpm->p.n; k++)
		point_field(mpm, f, k, out + (size_t)k * (size_t)particle_fields[f].components);
}
