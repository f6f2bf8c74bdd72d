/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_disc_integrate.h"

#include "atom.h"
#include "comm.h"
#include "compute.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "group.h"
#include "keywords.h"
#include "modify.h"
#include "pair_disc.h"
#include "rank_sums.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;

FixDiscIntegrate::FixDiscIntegrate(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg), own_state(lmp)
{
  time_integrate = 1;
  vector_flag = 1;
  size_vector = 8;
  global_freq = 1;
  extvector = 0;
  restart_global = 1;
  if (igroup != 0) error->all(FLERR, "fix disc/integrate moves every grain: its group must be 'all'");
  if (domain->dimension != 2 || domain->triclinic)
    error->all(FLERR, "fix disc/integrate needs 'dimension 2' and a rectangular cell");
  if (!atom->radius_flag || !atom->rmass_flag || !atom->omega_flag)
    error->all(FLERR, "fix disc/integrate needs radius, mass and rotation per atom: use 'atom_style sphere'");
  keywords().parse(3, narg, arg);
  check();
  for (int a = 0; a < 2; a++) {
    if (!axis[a].controlled) continue;
    if (!domain->periodicity[a])
      error->all(FLERR, "fix disc/integrate: a cell axis under stress control must be periodic");
    box_change |= a ? BOX_CHANGE_Y : BOX_CHANGE_X;
  }
  begin_stage();
  // of a pair style that is not of this plugin; runs look for computes of the virial before they call init()
  if (stress_control && !dynamic_cast<PairDisc *>(force->pair))
    pressure = modify->add_compute(fmt::format("{}_press all pressure NULL pair", id));
}

FixDiscIntegrate::~FixDiscIntegrate()
{
  if (pressure && modify->get_compute_by_id(fmt::format("{}_press", id)))
    modify->delete_compute(fmt::format("{}_press", id));
}

Keywords FixDiscIntegrate::keywords()
{
  return {lmp,
          "fix disc/integrate",
          {{"stress", 2, "S_x and S_y (a number or NULL)", [this](LAMMPS *, char **value) { set_stress(value); }},
           {"cell", 1, "lengths or strain", [this](LAMMPS *, char **value) { set_cell(value[0]); }},
           number("mass", mass_factor),
           number("rate", rate_cap),
           number("wall", wall_cap),
           number("convention", convention),
           number("drag", drag),
           number("quench", quench),
           {"gravity", 2, "g_x and g_y", [this](LAMMPS *, char **value) { set_gravity(value); }},
           {"fixed", 1, "a group", [this](LAMMPS *, char **value) { set_fixed(value[0]); }}}};
}

void FixDiscIntegrate::check() const
{
  if (mass_factor <= 0.0) error->all(FLERR, "fix disc/integrate: mass = {} must be positive", mass_factor);
  if (rate_cap < 0.0) error->all(FLERR, "fix disc/integrate: rate = {} must not be negative (0: no cap)", rate_cap);
  if (wall_cap < 0.0) error->all(FLERR, "fix disc/integrate: wall = {} must not be negative (0: no cap)", wall_cap);
  if (drag < 0.0) error->all(FLERR, "fix disc/integrate: drag = {} must not be negative", drag);
  if (quench != 0.0 && quench != 1.0) error->all(FLERR, "fix disc/integrate: quench = {} must be 0 or 1", quench);
  if (convention != 0.0 && std::fabs(convention) != 1.0)
    error->all(FLERR, "fix disc/integrate: convention = {} must be -1, 0 or 1", convention);
}

void FixDiscIntegrate::set_stress(char **value)
{
  for (int a = 0; a < 2; a++) {
    axis[a].controlled = strcmp(value[a], "NULL") != 0;
    axis[a].target = axis[a].controlled ? utils::numeric(FLERR, value[a], false, lmp) : 0.0;
  }
  stress_control = axis[0].controlled || axis[1].controlled;
}

void FixDiscIntegrate::set_cell(const std::string &value)
{
  if (value != "lengths" && value != "strain")
    error->all(FLERR, "fix disc/integrate: keyword 'cell' needs 'lengths' or 'strain', not '{}'", value);
  of_lengths = value == "lengths";
}

void FixDiscIntegrate::set_gravity(char **value)
{
  for (int a = 0; a < 2; a++)
    gravity[a] = utils::numeric(FLERR, value[a], false, lmp);
}

void FixDiscIntegrate::set_fixed(const std::string &value)
{
  const int found = group->find(value);
  if (found < 0)
    error->all(FLERR, "fix disc/integrate: there is no group '{}' to hold; define it before the fix", value);
  fixed = group->bitmask[found];
}

bool FixDiscIntegrate::moves(int i) const { return !(atom->mask[i] & fixed); }

int FixDiscIntegrate::modify_param(int narg, char **arg)
{
  const bool stress = strcmp(arg[0], "stress") == 0;
  if (!stress && strcmp(arg[0], "drag") != 0 && strcmp(arg[0], "quench") != 0) return 0;
  const bool before[2] = {axis[0].controlled, axis[1].controlled};
  const int used = keywords().parse_one(0, narg, arg);
  check();
  if (!stress) return used;
  for (int a = 0; a < 2; a++)
    if (axis[a].controlled && !before[a])
      error->all(FLERR, "fix_modify stress: axis {} was fixed when the fix was defined; define the fix anew to free it",
                 a ? 'y' : 'x');
  begin_stage();
  return used;
}

/* Strain counts from the present cell; the cell keeps its velocity dL/dt. */
void FixDiscIntegrate::begin_stage()
{
  double total = 0.0;
  for (int i = 0; i < atom->nlocal; i++)
    total += atom->rmass[i];
  MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_DOUBLE, MPI_SUM, world);
  inertia = mass_factor * total / (of_lengths ? 1.0 : std::sqrt(domain->prd[0] * domain->prd[1]));
  for (int a = 0; a < 2; a++) {
    if (axis[a].length0 > 0.0) axis[a].strain_rate *= axis[a].length0 / domain->prd[a];
    axis[a].length0 = domain->prd[a];
    if (!axis[a].controlled) axis[a].strain_rate = 0.0;
  }
}

int FixDiscIntegrate::setmask()
{
  const int mask = FixConst::INITIAL_INTEGRATE | FixConst::FINAL_INTEGRATE | FixConst::POST_NEIGHBOR;
  return dynamic_cast<PairDisc *>(force->pair) ? mask : mask | FixConst::PRE_FORCE | FixConst::POST_FORCE;
}

/* Grains change places in memory only when lists are rebuilt; divisions are dear. */
void FixDiscIntegrate::post_neighbor()
{
  if (!history) own_state.resize();
  inertia_of.resize(atom->nlocal);
  for (int i = 0; i < atom->nlocal; i++) {
    const double m = atom->rmass[i], r = atom->radius[i];
    inertia_of[i] = moves(i) ? disc::Inertia{m, 2.0 / (m * r * r)} : disc::Inertia{0.0, 0.0};    // I = m R^2/2
  }
}

void FixDiscIntegrate::init()
{
  if (!force->pair) error->all(FLERR, "fix disc/integrate needs a pair style");
  if (stress_control && !pressure != (dynamic_cast<PairDisc *>(force->pair) != nullptr))
    error->all(FLERR, "fix disc/integrate was defined for another pair style: define it again after pair_style");
  pair = dynamic_cast<PairDisc *>(force->pair);
  history = pair ? dynamic_cast<FixDiscHistory *>(modify->get_fix_by_id(FixDiscHistory::ID)) : nullptr;
  state = history ? &history->state : &own_state;
  if (!pair && !comm->ghost_velocity)
    error->all(FLERR, "fix disc/integrate needs velocities of ghost atoms: use 'comm_modify vel yes'");
  if (stress_control && inertia <= 0.0)
    error->all(FLERR, "fix disc/integrate: the grains have no mass; define the fix after the masses");
  if (pair) pair->needs_virial = pair->needs_virial || stress_control;
  state->fixed = fixed;
  std::copy(gravity, gravity + 2, state->gravity);
  for (int i = 0; i < atom->nlocal; i++)
    if (!moves(i)) {
      std::fill(atom->v[i], atom->v[i] + 3, 0.0);
      std::fill(atom->omega[i], atom->omega[i] + 3, 0.0);
    }
}

void FixDiscIntegrate::read_virial()
{
  if (pressure->invoked_vector != update->ntimestep) pressure->compute_vector();
  const double area = domain->prd[0] * domain->prd[1];
  for (int a = 0; a < 2; a++)
    axis[a].virial = pressure->vector[a] * area;
  pressure->addstep(update->ntimestep + 1);
}

/* Pair styles of LAMMPS know no motion of the cell: they see it as part of the velocities.  Ghosts lie where the affine
   motion is that of their image. */
void FixDiscIntegrate::pre_force(int)
{
  if (pair || !stress_control) return;
  const int nall = atom->nlocal + atom->nghost;
  velocity.resize(2 * static_cast<size_t>(nall));
  for (int i = 0; i < nall; i++)
    for (int a = 0; a < 2; a++) {
      velocity[2 * i + a] = atom->v[i][a];
      atom->v[i][a] += affine_rate[a] * (atom->x[i][a] - domain->boxlo[a]);
    }
}

void FixDiscIntegrate::post_force(int)
{
  if (pair) return;
  if (stress_control)
    for (int i = 0; i < atom->nlocal + atom->nghost; i++)
      std::copy(&velocity[2 * i], &velocity[2 * i] + 2, atom->v[i]);
  for (int i = 0; i < atom->nlocal; i++) {
    for (int a = 0; a < 2; a++)
      atom->f[i][a] = moves(i) ? atom->f[i][a] + atom->rmass[i] * gravity[a] : 0.0;
    if (!moves(i)) std::fill(atom->torque[i], atom->torque[i] + 3, 0.0);
  }
}

void FixDiscIntegrate::setup(int)
{
  if (!pair) post_force(0);
  // as the run that wrote the restart: forces and stress at half-step velocities
  if (history && history->continues_restart()) {
    history->restore_forces();
    return;
  }
  double mv2[2] = {0.0, 0.0};
  const double *const v = atom->v[0], *const m = atom->rmass;
  for (int i = 0; i < atom->nlocal; i++)
    for (int a = 0; a < 2; a++)
      mv2[a] += m[i] * v[3 * i + a] * v[3 * i + a];
  measure_stress(mv2);
}

/* ---- a step as LAMMPS takes it: its arrays are copied to the kernel's and back ---- */

void FixDiscIntegrate::initial_integrate(int)
{
  state->load(0, atom->nlocal);
  state->load_forces();
  integrate(false, true);
  state->store();
}

void FixDiscIntegrate::final_integrate()
{
  state->load(0, atom->nlocal);
  state->load_forces();
  integrate(true, false);
  state->store();
}

/* ---- a step ---- */

/* Half a kick ends a step; half a kick begins the next, then the cell moves its grains and the grains move in the cell.
   One pass does what does not depend on what the cell does in between. */
void FixDiscIntegrate::integrate(bool final, bool initial)
{
  if (final && initial && !stress_control && convention == 0.0) {
    pass<true, true, true>();
  } else if (final && initial && convention == 0.0) {
    pass<true, true, false>();
    final_integrate_cell();
    kick_cell(0.5 * update->dt);
    pass<false, false, true>();
  } else {
    if (final) {
      pass<true, false, false>();
      final_integrate_cell();
    }
    if (initial) {
      kick_cell(0.5 * update->dt);
      pass<false, true, true>();
    }
  }
}

template <bool FINAL, bool INITIAL, bool DRIFT> void FixDiscIntegrate::pass()
{
  const double dt = update->dt;
  disc::HalfKick kick;
  kick.dt = 0.5 * dt;
  std::copy(gravity, gravity + 2, kick.gravity);
  kick.omega_scaling = std::exp(-drag * kick.dt);
  for (int a = 0; a < 2; a++)
    kick.v_scaling[a] =
        kick.omega_scaling * std::exp(-convention * axis[a].strain_rate * axis[a].length0 / domain->prd[a] * kick.dt);
  disc::Drift drift;
  const bool cell_moves = DRIFT && scale_cell(drift);

  const bool scaled = (FINAL || INITIAL) && (drag > 0.0 || convention != 0.0);
  const auto kernel = scaled ? (cell_moves ? &disc::integrate<FINAL, INITIAL, true, DRIFT, DRIFT>
                                           : &disc::integrate<FINAL, INITIAL, true, DRIFT, false>)
                             : (cell_moves ? &disc::integrate<FINAL, INITIAL, false, DRIFT, DRIFT>
                                           : &disc::integrate<FINAL, INITIAL, false, DRIFT, false>);
  const disc::StepSums sums =
      kernel(kick, drift, inertia_of.data(), state->forces.data(), state->grains.data(), atom->nlocal);

  for (const double twice_kinetic : sums.scaled)
    drag_dissipated += 0.5 * (1.0 - kick.omega_scaling * kick.omega_scaling) * twice_kinetic;
  const double mv2[2] = {sums.mvx2, sums.mvy2};
  if (FINAL) measure_stress(mv2);
  if (DRIFT && !history) {
    if (!std::isfinite(sums.displacement_sq_sum))
      error->one(
          FLERR,
          "the position of a grain is not a number at step {}: centres of two grains coincide, or the step {} is "
          "far too large",
          update->ntimestep, update->dt);
    // with the mean of the lengths before and after, as velocities are those of the half step
    for (int a = 0; a < 2; a++)
      affine_rate[a] = (drift.cell_scaling[a] - 1.0) / (0.5 * (1.0 + drift.cell_scaling[a]) * dt);
  } else if (DRIFT) {
    history->pairs.require_number(sums.displacement_sq_sum);
    history->pairs.record_displacement(std::sqrt(sums.max_displacement_sq), drift.cell_scaling);
  }
}

void FixDiscIntegrate::final_integrate_cell()
{
  if (!stress_control) return;
  const double dt = update->dt;
  for (int a = 0; a < 2; a++) {
    const double now = domain->prd[a];
    const double change = -axis[a].strain_rate * axis[a].length0 * dt;
    work -= 0.5 * change / (now - 0.5 * change) * (axis[a].virial - convention * axis[a].mv2);
  }
  kick_cell(0.5 * dt);
}

/* The lower corner of the cell stays where it is.  Returns whether lengths changed. */
bool FixDiscIntegrate::scale_cell(disc::Drift &drift)
{
  const double dt = update->dt;
  for (int a = 0; a < 2; a++) {
    const double before = domain->prd[a];
    const double change = -axis[a].strain_rate * axis[a].length0 * dt;
    drift.cell_scaling[a] = 1.0 + change / before;
    drift.dt[a] = 0.5 * (1.0 + drift.cell_scaling[a]) * dt;
    drift.origin[a] = domain->boxlo[a];
    if (change == 0.0) continue;
    if (!(drift.cell_scaling[a] > 0.5))
      error->all(
          FLERR,
          "fix disc/integrate: the cell collapsed (length {} along {} shrinks by {} in one step); use a smaller step, "
          "a larger mass or a rate cap",
          before, a ? 'y' : 'x', -change);
    domain->boxhi[a] = domain->boxlo[a] + before * drift.cell_scaling[a];
    // half of the work at the old forces, half at the new ones (final_integrate_cell)
    work -= 0.5 * change / (before + 0.5 * change) * (axis[a].virial - convention * axis[a].mv2);
  }
  if (drift.cell_scaling[0] == 1.0 && drift.cell_scaling[1] == 1.0) return false;
  domain->set_global_box();
  domain->set_local_box();
  return true;
}

void FixDiscIntegrate::kick_cell(double dt)
{
  const double scaling = std::exp(-drag * dt);
  for (int k = 0; k < 2; k++) {
    Axis &a = axis[k];
    if (!a.controlled) continue;
    if (quench > 0.0 && (a.target - a.stress) * a.strain_rate < 0.0) a.strain_rate = 0.0;
    const double per_stress = of_lengths ? domain->prd[1 - k] / (a.length0 * inertia) : 1.0 / inertia;
    a.strain_rate = scaling * a.strain_rate + dt * per_stress * (a.target - a.stress);
    if (rate_cap > 0.0) a.strain_rate = std::fmin(std::fmax(a.strain_rate, -rate_cap), rate_cap);
    if (wall_cap > 0.0)
      a.strain_rate = std::fmin(std::fmax(a.strain_rate, -wall_cap / a.length0), wall_cap / a.length0);
  }
}

/* sigma_aa = (1/A) [sum of m v_a^2 + sum over pairs of F_a r_a] (G07 eq. 3) */
void FixDiscIntegrate::measure_stress(const double *mv2)
{
  if (!stress_control) return;
  double sums[4] = {mv2[0], mv2[1], pair ? pair->pair_virial[0] : 0.0, pair ? pair->pair_virial[1] : 0.0};
  if (comm->nprocs > 1) MPI_Allreduce(MPI_IN_PLACE, sums, 4, MPI_DOUBLE, MPI_SUM, world);
  const double area = domain->prd[0] * domain->prd[1];
  if (!pair) read_virial();
  for (int a = 0; a < 2; a++) {
    axis[a].mv2 = sums[a];
    if (pair) axis[a].virial = sums[2 + a];
    axis[a].stress = (sums[a] + axis[a].virial) / area;
  }
}

double FixDiscIntegrate::compute_vector(int n)
{
  switch (n) {
  case 0:
  case 1:
    return axis[n].stress;
  case 2:
  case 3:
    return axis[n - 2].strain_rate;
  case 4:
    return work;
  case 5:
    return inertia;
  default:
    break;
  }
  double total = n == 6 ? drag_dissipated : 0.0;
  if (n == 7)
    for (int i = 0; i < atom->nlocal; i++)
      if (moves(i)) total -= atom->rmass[i] * (gravity[0] * atom->x[i][0] + gravity[1] * atom->x[i][1]);
  MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_DOUBLE, MPI_SUM, world);
  return total;
}

void FixDiscIntegrate::write_restart(FILE *fp)
{
  std::vector<double> state = {
      axis[0].strain_rate, axis[1].strain_rate, axis[0].length0, axis[1].length0, inertia, work};
  for (const auto value : {&Axis::stress, &Axis::virial, &Axis::mv2})
    for (const Axis &a : axis)
      state.push_back(a.*value);
  save_rank_sums(world, {drag_dissipated}, state);
  if (comm->me != 0) return;
  const int size = static_cast<int>(state.size() * sizeof(double));
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(state.data(), size, 1, fp);
}

void FixDiscIntegrate::restart(char *buf)
{
  const auto *state = reinterpret_cast<const double *>(buf);
  for (int a = 0; a < 2; a++) {
    axis[a].strain_rate = axis[a].controlled ? state[a] : 0.0;
    axis[a].length0 = state[2 + a];
    axis[a].stress = state[6 + a];
    axis[a].virial = state[8 + a];
    axis[a].mv2 = state[10 + a];
  }
  inertia = state[4];
  work = state[5];
  drag_dissipated = restore_rank_sums(world, state + 12, 1)[0];
}
