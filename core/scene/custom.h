/* Values of the key table that need a reader of their own.  `target` is the struct that holds the key. */
#ifndef TMDEMPM_SCENE_CUSTOM_H
#define TMDEMPM_SCENE_CUSTOM_H

struct loader;
struct scene_key;
struct node;

#define READER(name) void name(struct loader *, const struct scene_key *, struct node *, void *target, const char *path)

READER(read_packing_file);
READER(read_material_law);
READER(read_material_name);
READER(read_body_shape);
READER(read_body_circle);
READER(read_body_outline);
READER(read_mask_file);
READER(read_motion_solution);
READER(read_motion_parameters);
READER(read_wall_shape);
READER(read_series);             /* a struct scene_series at key->offset */
READER(read_temperature_series); /* the same, from the scene's unit to K */
READER(read_freezing);
READER(read_box); /* lower corner at key->offset, upper at key->n_offset */
READER(read_grid_follow);
READER(read_stage_walls);
READER(read_contact_bodies);
READER(read_softening);
READER(read_stage_then);
READER(read_probe_where);
READER(read_component);
READER(read_range);
READER(read_pipelines);

#undef READER

#endif
