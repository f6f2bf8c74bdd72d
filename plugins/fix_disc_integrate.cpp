/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_disc_integrate.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "group.h"
#include "modify.h"
#include "pair_disc.h"
#include "rank_sums.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;

FixDiscIntegrate::FixDiscIntegrate(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
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
  parse(3, narg, arg);
  for (int a = 0; a < 2; a++) {
    if (!axis[a].controlled) continue;
    if (!domain->periodicity[a])
      error->all(FLERR, "fix disc/integrate: a cell axis under stress control must be periodic");
    box_change |= a ? BOX_CHANGE_Y : BOX_CHANGE_X;
  }
  begin_stage();
}

void FixDiscIntegrate::parse(int k, int narg, char **arg)
{
  while (k < narg) {
    const std::string keyword = arg[k];
    if (keyword == "stress" || keyword == "gravity" || keyword == "fixed" || keyword == "cell") {
      k += keyword == "stress"    ? parse_stress(k, narg, arg)
           : keyword == "gravity" ? parse_gravity(k, narg, arg)
           : keyword == "cell"    ? parse_cell(k, narg, arg)
                                  : parse_fixed(k, narg, arg);
      continue;
    }
    double *value = keyword == "mass"         ? &mass_factor
                    : keyword == "rate"       ? &rate_cap
                    : keyword == "wall"       ? &wall_cap
                    : keyword == "convention" ? &convention
                    : keyword == "drag"       ? &drag
                    : keyword == "quench"     ? &quench
                                              : nullptr;
    if (!value)
      error->all(FLERR,
                 "fix disc/integrate: unknown keyword '{}'; known are: stress cell mass rate wall convention "
                 "drag quench gravity fixed",
                 keyword);
    if (k + 1 >= narg) error->all(FLERR, "fix disc/integrate: keyword '{}' needs a value", keyword);
    *value = utils::numeric(FLERR, arg[k + 1], false, lmp);
    k += 2;
  }
  check();
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

int FixDiscIntegrate::parse_stress(int k, int narg, char **arg)
{
  if (k + 2 >= narg)
    error->all(FLERR, "fix disc/integrate: keyword 'stress' needs two values, S_x and S_y (a number or NULL)");
  for (int a = 0; a < 2; a++) {
    axis[a].controlled = strcmp(arg[k + 1 + a], "NULL") != 0;
    axis[a].target = axis[a].controlled ? utils::numeric(FLERR, arg[k + 1 + a], false, lmp) : 0.0;
  }
  stress_control = axis[0].controlled || axis[1].controlled;
  return 3;
}

int FixDiscIntegrate::parse_cell(int k, int narg, char **arg)
{
  const std::string value = k + 1 < narg ? arg[k + 1] : "";
  if (value != "lengths" && value != "strain")
    error->all(FLERR, "fix disc/integrate: keyword 'cell' needs 'lengths' or 'strain', not '{}'", value);
  of_lengths = value == "lengths";
  return 2;
}

int FixDiscIntegrate::parse_gravity(int k, int narg, char **arg)
{
  if (k + 2 >= narg) error->all(FLERR, "fix disc/integrate: keyword 'gravity' needs two values, g_x and g_y");
  for (int a = 0; a < 2; a++)
    gravity[a] = utils::numeric(FLERR, arg[k + 1 + a], false, lmp);
  return 3;
}

int FixDiscIntegrate::parse_fixed(int k, int narg, char **arg)
{
  if (k + 1 >= narg) error->all(FLERR, "fix disc/integrate: keyword 'fixed' needs a group");
  const int found = group->find(arg[k + 1]);
  if (found < 0)
    error->all(FLERR, "fix disc/integrate: there is no group '{}' to hold; define it before the fix", arg[k + 1]);
  fixed = group->bitmask[found];
  return 2;
}

bool FixDiscIntegrate::moves(int i) const { return !(atom->mask[i] & fixed); }

int FixDiscIntegrate::modify_param(int narg, char **arg)
{
  if (strcmp(arg[0], "drag") == 0 || strcmp(arg[0], "quench") == 0) {
    parse(0, std::min(narg, 2), arg);
    return 2;
  }
  if (strcmp(arg[0], "stress") != 0) return 0;
  const bool before[2] = {axis[0].controlled, axis[1].controlled};
  const int used = parse_stress(0, narg, arg);
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
    if (axis[a].start > 0.0) axis[a].strain_rate *= axis[a].start / domain->prd[a];
    axis[a].start = domain->prd[a];
    if (!axis[a].controlled) axis[a].strain_rate = 0.0;
  }
}

int FixDiscIntegrate::setmask()
{
  return FixConst::INITIAL_INTEGRATE | FixConst::FINAL_INTEGRATE | FixConst::POST_NEIGHBOR;
}

/* Grains change places in memory only when lists are rebuilt; divisions are dear. */
void FixDiscIntegrate::post_neighbor()
{
  inertia_of.resize(atom->nlocal);
  for (int i = 0; i < atom->nlocal; i++) {
    const double m = atom->rmass[i], r = atom->radius[i];
    inertia_of[i] = moves(i) ? disc::Inertia{m, 2.0 / (m * r * r)} : disc::Inertia{0.0, 0.0};    // I = m R^2/2
  }
}

void FixDiscIntegrate::init()
{
  pair = dynamic_cast<PairDisc *>(force->pair);
  if (!pair) error->all(FLERR, "fix disc/integrate works with the pair styles of its plugin, such as disc/cohesive");
  history = dynamic_cast<FixDiscHistory *>(modify->get_fix_by_id(FixDiscHistory::ID));
  if (stress_control && inertia <= 0.0)
    error->all(FLERR, "fix disc/integrate: the grains have no mass; define the fix after the masses");
  pair->wants_stress = pair->wants_stress || stress_control;
  history->fixed = fixed;
  std::copy(gravity, gravity + 2, history->gravity);
  for (int i = 0; i < atom->nlocal; i++)
    if (!moves(i)) {
      std::fill(atom->v[i], atom->v[i] + 3, 0.0);
      std::fill(atom->omega[i], atom->omega[i] + 3, 0.0);
    }
}

void FixDiscIntegrate::setup(int)
{
  if (history->goes_on()) {    // as the run that wrote the restart: forces and stress at half-step velocities
    history->restore_forces();
    return;
  }
  double kinetic[2] = {0.0, 0.0};
  const double *const v = atom->v[0], *const m = atom->rmass;
  for (int i = 0; i < atom->nlocal; i++)
    for (int a = 0; a < 2; a++)
      kinetic[a] += m[i] * v[3 * i + a] * v[3 * i + a];
  measure_stress(kinetic);
}

/* ---- a step as LAMMPS takes it: its arrays are carried to the kernel's and back ---- */

void FixDiscIntegrate::initial_integrate(int)
{
  history->load(0, atom->nlocal);
  history->load_actions();
  advance(false, true);
  history->store();
}

void FixDiscIntegrate::final_integrate()
{
  history->load(0, atom->nlocal);
  history->load_actions();
  advance(true, false);
  history->store();
}

/* ---- a step ---- */

/* Half a kick ends a step; half a kick begins the next, then the cell moves its grains and the grains move in the cell.
   One pass does what does not depend on what the cell does in between. */
void FixDiscIntegrate::advance(bool finish_last, bool begin_next)
{
  if (finish_last && begin_next && !stress_control && convention == 0.0) {
    pass<true, true, true>();
  } else if (finish_last && begin_next && convention == 0.0) {
    pass<true, true, false>();
    finish_cell();
    kick_cell(0.5 * update->dt);
    pass<false, false, true>();
  } else {
    if (finish_last) {
      pass<true, false, false>();
      finish_cell();
    }
    if (begin_next) {
      kick_cell(0.5 * update->dt);
      pass<false, true, true>();
    }
  }
}

template <bool FINISH, bool BEGIN, bool SHIFT> void FixDiscIntegrate::pass()
{
  const double dt = update->dt;
  disc::Kick half;
  half.dt = 0.5 * dt;
  std::copy(gravity, gravity + 2, half.gravity);
  half.kept_spin = std::exp(-drag * half.dt);
  for (int a = 0; a < 2; a++)
    half.kept[a] =
        half.kept_spin * std::exp(-convention * axis[a].strain_rate * axis[a].start / domain->prd[a] * half.dt);
  disc::Shift shift;
  const bool stretched = SHIFT && stretch_cell(shift);

  const bool scaled = (FINISH || BEGIN) && (drag > 0.0 || convention != 0.0);
  const auto advance = scaled ? (stretched ? &disc::advance<FINISH, BEGIN, true, SHIFT, SHIFT>
                                           : &disc::advance<FINISH, BEGIN, true, SHIFT, false>)
                              : (stretched ? &disc::advance<FINISH, BEGIN, false, SHIFT, SHIFT>
                                           : &disc::advance<FINISH, BEGIN, false, SHIFT, false>);
  const disc::Passed sums =
      advance(half, shift, inertia_of.data(), history->actions.data(), history->grains.data(), atom->nlocal);

  for (const double scaled : sums.scaled)
    dragged += 0.5 * (1.0 - half.kept_spin * half.kept_spin) * scaled;
  const double kinetic[2] = {sums.xx, sums.yy};
  if (FINISH) measure_stress(kinetic);
  if (SHIFT) {
    history->require_number(sums.sum);
    history->moved(std::sqrt(sums.largest), shift.stretch);
  }
}

void FixDiscIntegrate::finish_cell()
{
  if (!stress_control) return;
  const double dt = update->dt;
  for (int a = 0; a < 2; a++) {
    const double now = domain->prd[a];
    const double change = -axis[a].strain_rate * axis[a].start * dt;
    work -= 0.5 * change / (now - 0.5 * change) * (axis[a].virial - convention * axis[a].kinetic);
  }
  kick_cell(0.5 * dt);
}

/* The lower corner of the cell stays where it is.  Returns whether lengths changed. */
bool FixDiscIntegrate::stretch_cell(disc::Shift &shift)
{
  const double dt = update->dt;
  for (int a = 0; a < 2; a++) {
    const double before = domain->prd[a];
    const double change = -axis[a].strain_rate * axis[a].start * dt;
    shift.stretch[a] = 1.0 + change / before;
    shift.drift[a] = 0.5 * (1.0 + shift.stretch[a]) * dt;
    shift.corner[a] = domain->boxlo[a];
    if (change == 0.0) continue;
    if (!(shift.stretch[a] > 0.5))
      error->all(
          FLERR,
          "fix disc/integrate: the cell collapsed (length {} along {} shrinks by {} in one step); use a smaller step, "
          "a larger mass or a rate cap",
          before, a ? 'y' : 'x', -change);
    domain->boxhi[a] = domain->boxlo[a] + before * shift.stretch[a];
    // half of the work at the old forces, half at the new ones (finish_cell)
    work -= 0.5 * change / (before + 0.5 * change) * (axis[a].virial - convention * axis[a].kinetic);
  }
  if (shift.stretch[0] == 1.0 && shift.stretch[1] == 1.0) return false;
  domain->set_global_box();
  domain->set_local_box();
  return true;
}

void FixDiscIntegrate::kick_cell(double dt)
{
  const double kept = std::exp(-drag * dt);
  for (int k = 0; k < 2; k++) {
    Axis &a = axis[k];
    if (!a.controlled) continue;
    if (quench > 0.0 && (a.target - a.stress) * a.strain_rate < 0.0) a.strain_rate = 0.0;
    const double per_stress = of_lengths ? domain->prd[1 - k] / (a.start * inertia) : 1.0 / inertia;
    a.strain_rate = kept * a.strain_rate + dt * per_stress * (a.target - a.stress);
    if (rate_cap > 0.0) a.strain_rate = std::fmin(std::fmax(a.strain_rate, -rate_cap), rate_cap);
    if (wall_cap > 0.0) a.strain_rate = std::fmin(std::fmax(a.strain_rate, -wall_cap / a.start), wall_cap / a.start);
  }
}

/* sigma_aa = (1/A) [sum of m v_a^2 + sum over pairs of F_a r_a] (G07 eq. 3) */
void FixDiscIntegrate::measure_stress(const double *kinetic)
{
  if (!stress_control) return;
  double sums[4] = {kinetic[0], kinetic[1], pair->force_moment[0], pair->force_moment[1]};
  if (comm->nprocs > 1) MPI_Allreduce(MPI_IN_PLACE, sums, 4, MPI_DOUBLE, MPI_SUM, world);
  const double area = domain->prd[0] * domain->prd[1];
  for (int a = 0; a < 2; a++) {
    axis[a].kinetic = sums[a];
    axis[a].virial = sums[2 + a];
    axis[a].stress = (sums[a] + sums[2 + a]) / area;
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
  double total = n == 6 ? dragged : 0.0;
  if (n == 7)
    for (int i = 0; i < atom->nlocal; i++)
      if (moves(i)) total -= atom->rmass[i] * (gravity[0] * atom->x[i][0] + gravity[1] * atom->x[i][1]);
  MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_DOUBLE, MPI_SUM, world);
  return total;
}

void FixDiscIntegrate::write_restart(FILE *fp)
{
  std::vector<double> state = {axis[0].strain_rate, axis[1].strain_rate, axis[0].start, axis[1].start, inertia, work};
  for (const auto value : {&Axis::stress, &Axis::virial, &Axis::kinetic})
    for (const Axis &a : axis)
      state.push_back(a.*value);
  save_rank_sums(world, {dragged}, state);
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
    axis[a].start = state[2 + a];
    axis[a].stress = state[6 + a];
    axis[a].virial = state[8 + a];
    axis[a].kinetic = state[10 + a];
  }
  inertia = state[4];
  work = state[5];
  dragged = restore_rank_sums(world, state + 12, 1)[0];
}
