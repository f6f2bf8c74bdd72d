/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "pair_disc.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "memory.h"
#include "modify.h"
#include "neighbor.h"

#include <cmath>

using namespace LAMMPS_NS;
using disc::Neighbours;

namespace
{
enum Column {
  ID_I,
  ID_J,
  STATE,
  BX,
  BY,
  GAP,
  ELASTIC,
  VISCOUS,
  ATTRACTION,
  TANGENTIAL,
  MOMENT,
  STRETCH,
  ROTATION,
  SLIDING,
  ROLLING,
  COLUMNS
};
enum Sum { E_ELASTIC, E_TANGENTIAL, E_ROLLING, E_ADHESIVE, D_VISCOUS, D_SLIDING, D_ROLLING, SUMS };
}    // namespace

PairDisc::PairDisc(LAMMPS *lmp) : Pair(lmp)
{
  single_enable = 1;
  single_extra = COLUMNS;
  svector = new double[COLUMNS]{};
  nextra = SUMS;
  pvector = new double[SUMS]{};
  restartinfo = 1;
  one_coeff = 1;
  finitecutflag = 1;
  no_virial_fdotr_compute = 1;
  centroidstressflag = CENTROID_NOTAVAIL;
}

PairDisc::~PairDisc()
{
  delete[] svector;
  delete[] pvector;
  if (allocated) {
    memory->destroy(setflag);
    memory->destroy(cutsq);
  }
  // the plugin loader may have deleted the fix already
  if (history && modify && modify->get_fix_by_id(FixDiscHistory::ID)) modify->delete_fix(FixDiscHistory::ID);
}

void PairDisc::init_style()
{
  if (domain->dimension != 2) error->all(FLERR, "pair_style {} is for discs: use 'dimension 2'", force->pair_style);
  if (!atom->radius_flag || !atom->rmass_flag || !atom->omega_flag || !atom->torque_flag)
    error->all(FLERR, "pair_style {} needs radius, mass and rotation per atom: use 'atom_style sphere'",
               force->pair_style);
  if (!atom->tag_enable)
    error->all(FLERR, "pair_style {} needs atom IDs: do not use 'atom_modify id no'", force->pair_style);
  if (!comm->ghost_velocity)
    error->all(FLERR, "pair_style {} needs velocities of ghost atoms: use 'comm_modify vel yes'", force->pair_style);
  if (domain->triclinic)
    error->all(FLERR, "pair_style {} works in rectangular cells only, this one is triclinic", force->pair_style);
  neighbor->add_request(this, NeighConst::REQ_SIZE);
  auto *fix = modify->get_fix_by_id(FixDiscHistory::ID);
  if (!fix) fix = modify->add_fix(std::string(FixDiscHistory::ID) + " all disc/history");
  history = dynamic_cast<FixDiscHistory *>(fix);
  if (!history)
    error->all(FLERR, "fix ID {} belongs to pair_style {}; give your fix another ID", FixDiscHistory::ID,
               force->pair_style);
  history->range = range();
  wants_stress = false;    // fixes that need it ask again in their init()
}

bool PairDisc::counted_once(int j) const { return force->newton_pair || j < atom->nlocal; }

PairDisc::Interaction PairDisc::geometry(const Neighbours &p) const
{
  Interaction now;
  now.bx = atom->x[p.j][0] - atom->x[p.i][0];
  now.by = atom->x[p.j][1] - atom->x[p.i][1];
  now.distance = std::sqrt(now.bx * now.bx + now.by * now.by);
  now.gap = now.distance - (p.ri + p.rj);
  return now;
}

void PairDisc::tally_energy()
{
  Energy total;
  each([&](const Neighbours &, const Interaction &now, double weight) {
    const Energy e = energy(now);
    total.elastic += weight * e.elastic;
    total.tangential += weight * e.tangential;
    total.rolling += weight * e.rolling;
    total.adhesive += weight * e.adhesive;
  });
  eng_vdwl = total.sum();
  const disc::Loss &loss = history->loss;
  const double sums[SUMS] = {total.elastic, total.tangential, total.rolling, total.adhesive,
                             loss.viscous,  loss.sliding,     loss.rolling};
  std::copy(sums, sums + SUMS, pvector);
}

/* Contact output for compute pair/local: reads the records, changes nothing. */
double PairDisc::single(int i, int j, int, int, double, double, double, double &fforce)
{
  if (!history || !history->current())
    error->one(FLERR, "the contact table is out of date since the last run: use 'run 0' before the output");
  const Neighbours *p = history->find(i, j);
  fforce = 0.0;
  std::fill(svector, svector + COLUMNS, 0.0);
  if (!p) return 0.0;
  const Interaction now = interaction(*p);
  svector[ID_I] = atom->tag[i];
  svector[ID_J] = atom->tag[j];
  svector[STATE] = now.state;
  svector[BX] = now.bx;
  svector[BY] = now.by;
  svector[GAP] = now.gap;
  svector[ELASTIC] = now.elastic;
  svector[VISCOUS] = now.viscous;
  svector[ATTRACTION] = now.attraction;
  svector[TANGENTIAL] = now.tangential;
  svector[MOMENT] = now.moment;
  svector[STRETCH] = now.stretch;
  svector[ROTATION] = now.rotation;
  svector[SLIDING] = now.sliding;
  svector[ROLLING] = now.rolling;
  fforce = now.normal() / now.distance;
  return energy(now).sum();
}
