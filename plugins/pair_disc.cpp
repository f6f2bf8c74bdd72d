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
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;

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

PairDisc::PairDisc(LAMMPS *lmp) : Pair(lmp), ghosts(lmp)
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
  comm_forward = 4;    // of `ghosts`
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

void PairDisc::settings(int narg, char **arg)
{
  const char *const style = force->pair_style;
  account = second_order = true;
  for (int k = 0; k < narg; k += 2) {
    const std::string keyword = arg[k];
    if (keyword != "account" && keyword != "scheme")
      error->all(FLERR, "pair_style {}: unknown keyword '{}'; known are: account yes|no, scheme second|paper", style,
                 keyword);
    if (k + 1 >= narg) error->all(FLERR, "pair_style {}: keyword '{}' needs a value", style, keyword);
    const std::string value = arg[k + 1];
    if (keyword == "account")
      account = utils::logical(FLERR, value, false, lmp);
    else if (value == "second" || value == "paper")
      second_order = value == "second";
    else
      error->all(FLERR, "pair_style {}: scheme '{}' is unknown; known are: second, paper", style, value);
  }
}

void PairDisc::read_coefficients(int narg, char **arg, const std::vector<Coefficient> &known)
{
  const char *const style = force->pair_style;
  if (narg < 2 || std::string(arg[0]) != "*" || std::string(arg[1]) != "*")
    error->all(FLERR, "pair_coeff of {} must start with '* *': one material for all grains", style);
  for (int k = 2; k < narg; k += 2) {
    const std::string keyword = arg[k];
    const auto found = std::find_if(known.begin(), known.end(), [&](const auto &one) { return keyword == one.name; });
    if (found == known.end()) {
      std::string names;
      for (const Coefficient &one : known)
        names += std::string(" ") + one.name;
      error->all(FLERR, "pair_coeff of {}: unknown keyword '{}'; known are:{}", style, keyword, names);
    }
    if (k + 1 >= narg) error->all(FLERR, "pair_coeff of {}: keyword '{}' needs a value", style, keyword);
    *found->value = utils::numeric(FLERR, arg[k + 1], false, lmp);
  }
  allocate();
}

void PairDisc::allocate()
{
  const int n = atom->ntypes + 1;
  if (!allocated) {
    memory->create(setflag, n, n, "pair:setflag");
    memory->create(cutsq, n, n, "pair:cutsq");
  }
  allocated = 1;
  for (int i = 1; i < n; i++)
    for (int j = i; j < n; j++)
      setflag[i][j] = 1;
}

double PairDisc::largest_diameter() const
{
  double found = 0.0;
  for (int i = 0; i < atom->nlocal; i++)
    found = std::max(found, 2.0 * atom->radius[i]);
  MPI_Allreduce(MPI_IN_PLACE, &found, 1, MPI_DOUBLE, MPI_MAX, world);
  return found;
}

void PairDisc::write_law(FILE *fp, const void *law, size_t bytes) const
{
  fwrite(law, bytes, 1, fp);
  fwrite(&account, sizeof(account), 1, fp);
  fwrite(&second_order, sizeof(second_order), 1, fp);
}

void PairDisc::read_law(FILE *fp, void *law, size_t bytes)
{
  if (comm->me == 0) {
    utils::sfread(FLERR, law, bytes, 1, fp, nullptr, error);
    utils::sfread(FLERR, &account, sizeof(account), 1, fp, nullptr, error);
    utils::sfread(FLERR, &second_order, sizeof(second_order), 1, fp, nullptr, error);
  }
  MPI_Bcast(law, static_cast<int>(bytes), MPI_BYTE, 0, world);
  MPI_Bcast(&account, sizeof(account), MPI_BYTE, 0, world);
  MPI_Bcast(&second_order, sizeof(second_order), MPI_BYTE, 0, world);
  allocate();
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

/* ---- forces ---- */

void PairDisc::choose_close()
{
  history->load(0, atom->nlocal + atom->nghost);
  history->choose_close();
}

void PairDisc::evaluate()
{
  history->choose_close();
  const disc::Sums sums = sweep(wants_stress);
  force_moment[0] = sums.xx;
  force_moment[1] = sums.yy;
  force_moment[2] = sums.xy;
  history->lost.viscous += sums.viscous;
  history->lost.sliding += sums.sliding;
  history->lost.rolling += sums.rolling;
  disc::Extremes &most = history->extremes;
  most.overlap = std::max(most.overlap, sums.overlap);
  most.approach = std::max(most.approach, sums.approach);
  most.advance = std::max(most.advance, sums.approach * history->motion.dt);
}

/* Before a run: no time passes, velocities are those of this moment, the memory of earlier ones stays; and all of it
   where a run goes on from a restart. */
void PairDisc::evaluate_standing()
{
  history->motion.dt = history->motion.ahead = 0.0;
  history->motion.carry[0] = history->motion.carry[1] = 1.0;
  history->choose_close();
  const disc::Contacts before = history->close;
  const disc::Extremes most = history->extremes;
  evaluate();
  if (history->goes_on()) {
    history->close = before;
    history->extremes = most;
  } else {
    history->close.speed = before.speed;
    history->close.sideways = before.sideways;
  }
}

void PairDisc::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  if (eflag_atom || vflag_atom)
    error->all(FLERR, "pair_style {} has no per-atom energy or stress; use the contact table of compute pair/local",
               force->pair_style);
  const int nlocal = atom->nlocal;
  history->load(0, nlocal + atom->nghost);
  history->begin_actions();
  const bool stress_at_every_step = wants_stress;
  wants_stress = wants_stress || vflag_global;
  if (update->setupflag)
    evaluate_standing();
  else
    evaluate();
  wants_stress = stress_at_every_step;
  if (force->newton_pair) ghosts.collect(history->actions);

  double *const f = atom->f[0], *const torque = atom->torque[0];
  for (int i = 0, k = 0; i < nlocal; i++, k += 3) {
    if (atom->mask[i] & history->fixed) continue;
    const disc::Action &a = history->actions[i];
    f[k] += a.fx;
    f[k + 1] += a.fy;
    torque[k + 2] += a.moment + history->grains[i].r * a.tangential;
  }
  if (eflag_global) tally_energy();
  if (vflag_global) {
    virial[0] += force_moment[0];
    virial[1] += force_moment[1];
    virial[3] += force_moment[2];
  }
}

/* ---- ghosts of the kernel's arrays ---- */

const std::vector<disc::Grain> &PairDisc::refreshed_grains()
{
  history->load(0, atom->nlocal);
  ghosts.refresh(history->grains, true);
  return history->grains;
}

int PairDisc::pack_forward_comm(int n, int *list, double *buf, int pbc_flag, int *pbc)
{
  return ghosts.pack(n, list, buf, pbc_flag, pbc);
}

void PairDisc::unpack_forward_comm(int n, int first, double *buf) { ghosts.unpack(n, first, buf); }

/* ---- sums and contact output ---- */

PairDisc::Interaction PairDisc::geometry(int c) const
{
  const int i = history->close.i[c], j = history->close.j[c];
  Interaction now;
  now.bx = atom->x[j][0] - atom->x[i][0];
  now.by = atom->x[j][1] - atom->x[i][1];
  now.distance = std::sqrt(now.bx * now.bx + now.by * now.by);
  now.gap = now.distance - (atom->radius[i] + atom->radius[j]);
  return now;
}

void PairDisc::tally_energy()
{
  Energy total;
  each([&](int, int, const Interaction &now, double weight) {
    const Energy e = energy(now);
    total.elastic += weight * e.elastic;
    total.tangential += weight * e.tangential;
    total.rolling += weight * e.rolling;
    total.adhesive += weight * e.adhesive;
  });
  eng_vdwl = total.sum();
  const disc::Sums &lost = history->lost;
  const double sums[SUMS] = {total.elastic, total.tangential, total.rolling, total.adhesive,
                             lost.viscous,  lost.sliding,     lost.rolling};
  std::copy(sums, sums + SUMS, pvector);
}

/* Contact output for compute pair/local: reads the records, changes nothing. */
double PairDisc::single(int i, int j, int, int, double, double, double, double &fforce)
{
  if (!history || !history->current())
    error->one(FLERR, "the contact table is out of date since the last run: use 'run 0' before the output");
  const int c = history->find(i, j);
  fforce = 0.0;
  std::fill(svector, svector + COLUMNS, 0.0);
  if (c < 0) return 0.0;
  const Interaction now = interaction(c);
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
