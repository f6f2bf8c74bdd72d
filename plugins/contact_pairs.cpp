/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "contact_pairs.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "force.h"
#include "neigh_list.h"
#include "pair_disc_tail.h"

#include <cmath>

using namespace LAMMPS_NS;

void ContactPairs::init(const char *user)
{
  own = dynamic_cast<PairDisc *>(force->pair);
  if (own) return;
  contact = force->pair_match("^gran", 0);
  tail = force->pair_match("disc/tail", 1);
  if (!contact || !contact->single_enable || contact->single_extra < 3)
    error->all(FLERR,
               "{} cannot read the contacts of pair_style {}: it knows the pair styles of its plugin, such as "
               "disc/cohesive, and granular, gran/hooke/history and the like, alone or beside disc/tail in "
               "hybrid/overlay",
               user, force->pair_style ? force->pair_style : "none");
  if (!comm->ghost_velocity) error->all(FLERR, "{} needs velocities of ghost atoms: use 'comm_modify vel yes'", user);
  range = tail ? dynamic_cast<PairDiscTail *>(tail)->range() : 0.0;
}

void ContactPairs::refresh()
{
  if (own) {
    grains = &own->refreshed_grains();
    return;
  }
  comm->forward_comm();    // ghosts have the velocities of the force evaluation, half a step old
  listed.clear();
  list_contacts();
  if (tail) list_tail();
}

double ContactPairs::approach(int i, int j, const PairDisc::Interaction &now) const
{
  if (own) {
    const disc::Grain &a = (*grains)[i], &b = (*grains)[j];
    return ((a.vx - b.vx) * now.bx + (a.vy - b.vy) * now.by) / now.distance;
  }
  const double *const a = atom->v[i], *const b = atom->v[j];
  return ((a[0] - b[0]) * now.bx + (a[1] - b[1]) * now.by) / now.distance;
}

PairDisc::Interaction ContactPairs::geometry(int i, int j) const
{
  PairDisc::Interaction now;
  now.bx = atom->x[j][0] - atom->x[i][0];
  now.by = atom->x[j][1] - atom->x[i][1];
  now.distance = std::sqrt(now.bx * now.bx + now.by * now.by);
  now.gap = now.distance - (atom->radius[i] + atom->radius[j]);
  return now;
}

double ContactPairs::weight(int j) const { return force->newton_pair || j < atom->nlocal ? 1.0 : 0.5; }

/* Add the pairs of `list` that `interacts` finds to interact; it says so, and fills in their forces. */
template <class Interacts> void ContactPairs::add_pairs(const NeighList *list, Interacts interacts)
{
  for (int ii = 0; ii < list->inum; ii++) {
    const int i = list->ilist[ii];
    for (int jj = 0; jj < list->numneigh[i]; jj++) {
      const int j = list->firstneigh[i][jj] & NEIGHMASK;
      PairDisc::Interaction now = geometry(i, j);
      if (interacts(i, j, now)) listed.push_back({i, j, now, weight(j)});
    }
  }
}

/* Force of `style` along the normal between i and j, positive where it repels. */
double ContactPairs::normal_force(Pair *style, int i, int j, double distance) const
{
  double along;
  style->single(i, j, atom->type[i], atom->type[j], distance * distance, 1.0, 1.0, along);
  return along * distance;
}

/* Pairs that touch, from the list of the contact style, whose history belongs to it. */
void ContactPairs::list_contacts()
{
  add_pairs(contact->list, [&](int i, int j, PairDisc::Interaction &now) {
    if (now.gap >= 0.0) return false;
    now.state = PairDisc::CONTACT;
    now.elastic = normal_force(contact, i, j, now.distance);
    // svector begins with the tangential force on i; t is the normal from i to j, turned by +90 degrees
    now.tangential = (contact->svector[0] * now.by - contact->svector[1] * now.bx) / now.distance;
    if (tail) now.attraction = normal_force(tail, i, j, now.distance);
    return true;
  });
}

void ContactPairs::list_tail()
{
  add_pairs(tail->list, [&](int i, int j, PairDisc::Interaction &now) {
    if (now.gap < 0.0 || now.gap >= range) return false;
    now.state = PairDisc::DISTANT;
    now.attraction = normal_force(tail, i, j, now.distance);
    return true;
  });
}
