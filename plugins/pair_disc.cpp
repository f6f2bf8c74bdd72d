/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "pair_disc.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "keywords.h"
#include "memory.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;

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
  account = second_order = true;
  const Keywords keywords(
      lmp, fmt::format("pair_style {}", force->pair_style),
      {logical("account", account),
       {"scheme", 1, "extrapolated or half_step", [this](LAMMPS *, char **value) { set_scheme(value[0]); }}});
  keywords.parse(0, narg, arg);
}

/* `second` and `paper` are the names of version 0.3 and before. */
void PairDisc::set_scheme(const std::string &value)
{
  second_order = value == "extrapolated" || value == "second";
  if (!second_order && value != "half_step" && value != "paper")
    error->all(FLERR,
               "pair_style {}: scheme '{}' is unknown; known are: extrapolated, half_step (of old: second, paper)",
               force->pair_style, value);
}

void PairDisc::read_coefficients(int narg, char **arg, const std::vector<Coefficient> &known)
{
  const char *const style = force->pair_style;
  if (narg < 2 || std::string(arg[0]) != "*" || std::string(arg[1]) != "*")
    error->all(FLERR, "pair_coeff of {} must start with '* *': one material for all grains", style);
  std::vector<Keyword> table;
  for (const Coefficient &one : known)
    table.push_back(number(one.name, *one.value));
  Keywords(lmp, fmt::format("pair_coeff of {}", style), table).parse(2, narg, arg);
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
  history->pairs.cutoff_gap = cutoff_gap();
  history->pairs.second_order = second_order;
  needs_virial = false;    // fixes that need it ask again in their init()
}

bool PairDisc::counted_once(int j) const { return force->newton_pair || j < atom->nlocal; }

/* ---- forces ---- */

void PairDisc::rebuild_pair_list()
{
  history->state.load(0, atom->nlocal + atom->nghost);
  history->pairs.rebuild_pair_list(*this);
}

void PairDisc::evaluate()
{
  history->pairs.rebuild_pair_list(*this);
  const disc::PairSums sums = compute_active_pairs(needs_virial);
  pair_virial[0] = sums.xx;
  pair_virial[1] = sums.yy;
  pair_virial[2] = sums.xy;
  history->state.add_sums(sums);
}

/* Before a run: no time passes, velocities are those of this moment, those of the step before stay in the history; and
   all of the history stays where a run goes on from a restart. */
void PairDisc::evaluate_setup()
{
  disc::ActivePairs &active = history->pairs.active;
  history->state.stop_kinematics();
  history->pairs.rebuild_pair_list(*this);
  const disc::ActivePairs before = active;
  const disc::Extremes extremes = history->state.extremes;
  evaluate();
  if (history->continues_restart()) {
    active = before;
    history->state.extremes = extremes;
    return;
  }
  const disc::HistoryColumns &columns = history->pairs.columns;
  for (int m = 0; m < columns.count; m++)
    if (columns[m].velocity()) active.history[m] = before.history[m];
}

void PairDisc::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  if (eflag_atom || vflag_atom)
    error->all(FLERR, "pair_style {} has no per-atom energy or stress; use the contact table of compute pair/local",
               force->pair_style);
  const int nlocal = atom->nlocal;
  DiscState &state = history->state;
  state.load(0, nlocal + atom->nghost);
  state.reset_forces();
  const bool virial_at_every_step = needs_virial;
  needs_virial = needs_virial || vflag_global;
  if (update->setupflag)
    evaluate_setup();
  else
    evaluate();
  needs_virial = virial_at_every_step;
  if (force->newton_pair) ghosts.reverse_comm(state.forces);

  double *const f = atom->f[0], *const torque = atom->torque[0];
  for (int i = 0, k = 0; i < nlocal; i++, k += 3) {
    if (atom->mask[i] & state.fixed) continue;
    const disc::GrainForce &sum = state.forces[i];
    f[k] += sum.fx;
    f[k + 1] += sum.fy;
    torque[k + 2] += sum.moment + state.grains[i].r * sum.tangential;
  }
  if (eflag_global) tally_energy();
  if (vflag_global) {
    virial[0] += pair_virial[0];
    virial[1] += pair_virial[1];
    virial[3] += pair_virial[2];
  }
}

/* ---- ghosts of the kernel's arrays ---- */

const std::vector<disc::Grain> &PairDisc::refreshed_grains()
{
  history->state.load(0, atom->nlocal);
  ghosts.forward_comm(history->state.grains, true);
  return history->state.grains;
}

int PairDisc::pack_forward_comm(int n, int *list, double *buf, int pbc_flag, int *pbc)
{
  return ghosts.pack(n, list, buf, pbc_flag, pbc);
}

void PairDisc::unpack_forward_comm(int n, int first, double *buf) { ghosts.unpack(n, first, buf); }

/* ---- sums and contact output ---- */

PairDisc::Interaction PairDisc::geometry(int c) const
{
  const int i = history->pairs.active.i[c], j = history->pairs.active.j[c];
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
  for_each_pair([&](int, int, const Interaction &now, double weight) {
    const Energy e = energy(now);
    total.elastic += weight * e.elastic;
    total.tangential += weight * e.tangential;
    total.rolling += weight * e.rolling;
    total.adhesive += weight * e.adhesive;
  });
  eng_vdwl = total.sum();
  const disc::PairSums &dissipated = history->state.dissipated;
  const double sums[SUMS] = {total.elastic,      total.tangential,   total.rolling,     total.adhesive,
                             dissipated.viscous, dissipated.sliding, dissipated.rolling};
  std::copy(sums, sums + SUMS, pvector);
}

/* Contact output for compute pair/local: reads the active pairs, changes nothing. */
double PairDisc::single(int i, int j, int, int, double, double, double, double &fforce)
{
  if (!history || !history->up_to_date())
    error->one(FLERR, "the contact table is out of date since the last run: use 'run 0' before the output");
  const int c = history->pairs.find(i, j);
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
  svector[DU] = now.xi_t;
  svector[DTHETA] = now.xi_r;
  svector[SLIDING] = now.sliding;
  svector[ROLLING] = now.rolling;
  fforce = now.normal() / now.distance;
  return energy(now).sum();
}
