/* Bonds from the host's side: how they come about, and how they go where no sub-step is made. */
#include "rve/model.h"

void rve_install_bonds(const struct rve_model *model, void *state)
{
	const struct rve_layout *layout = &model->layout;
	struct rve_head *head = state;
	unsigned char *flag = (unsigned char *)state + layout->flag;
	if (head->flags & (RVE_GAS | RVE_FROZEN) || !(model->params.bond_strength > 0.0))
		return;
	head->bonds_intact = 0;
	for (int level = 0; level < layout->levels; level++)
		for (int row = 0; row < layout->n; row++) {
			struct rve_contact contact;
			const int p = rve_slot(layout, state, row, level);
			if (p < 0)
				continue;
			if (rve_inspect_slot(model, state, row, p, &contact) && contact.normal_force > 0.0)
				flag[p] = BOND_INTACT;
			head->bonds_intact += flag[p] == BOND_INTACT;
		}
	head->bonds_installed = head->bonds_intact;
}

void rve_melt_bonds(const struct rve_model *model, void *state, double T)
{
	struct rve_head *head = state;
	unsigned char *flag = (unsigned char *)state + model->layout.flag;
	if (head->bonds_intact == 0 || !(T > model->params.bond_melting))
		return;
	const int slots = model->packed ? model->layout.pairs : head->level_first[head->levels];
	for (int p = 0; p < slots; p++)
		flag[p] = flag[p] == BOND_INTACT ? BOND_BROKEN : flag[p];
	head->bonds_intact = 0;
}
