/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_disc_integrate.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "pair_disc.h"
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
  size_vector = 7;
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
    if (keyword == "stress") {
      k += parse_stress(k, narg, arg);
      continue;
    }
    double *value = keyword == "mass"         ? &mass_factor
                    : keyword == "rate"       ? &rate_cap
                    : keyword == "convention" ? &convention
                    : keyword == "drag"       ? &drag
                                              : nullptr;
    if (!value)
      error->all(FLERR, "fix disc/integrate: unknown keyword '{}'; known are: stress mass rate convention drag",
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
  if (drag < 0.0) error->all(FLERR, "fix disc/integrate: drag = {} must not be negative", drag);
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

int FixDiscIntegrate::modify_param(int narg, char **arg)
{
  if (strcmp(arg[0], "drag") == 0) {
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
  inertia = mass_factor * total / std::sqrt(domain->prd[0] * domain->prd[1]);
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
  inverse.resize(atom->nlocal);
  for (int i = 0; i < atom->nlocal; i++) {
    const double m = atom->rmass[i], r = atom->radius[i];
    inverse[i] = {1.0 / m, 2.0 / (m * r * r)};    // I = m R^2/2
  }
}

void FixDiscIntegrate::init()
{
  pair = dynamic_cast<PairDisc *>(force->pair);
  if (!pair) error->all(FLERR, "fix disc/integrate works with the pair styles of its plugin, such as disc/cohesive");
  if (stress_control && inertia <= 0.0)
    error->all(FLERR, "fix disc/integrate: the grains have no mass; define the fix after the masses");
  pair->wants_stress = pair->wants_stress || stress_control;
}

void FixDiscIntegrate::setup(int) { measure_stress(); }

/* Half a kick, then the cell moves its grains and the grains move in the cell.  The lower corner stays where it is. */
void FixDiscIntegrate::initial_integrate(int)
{
  const double dt = update->dt;
  kick_cell(0.5 * dt);
  kick_grains(0.5 * dt);

  double stretch[2] = {1.0, 1.0};
  for (int a = 0; a < 2; a++) {
    const double before = domain->prd[a];
    const double change = -axis[a].strain_rate * axis[a].start * dt;
    if (change == 0.0) continue;
    stretch[a] = 1.0 + change / before;
    if (!(stretch[a] > 0.5))
      error->all(
          FLERR,
          "fix disc/integrate: the cell collapsed (length {} along {} shrinks by {} in one step); use a smaller step, "
          "a larger mass or a rate cap",
          before, a ? 'y' : 'x', -change);
    domain->boxhi[a] = domain->boxlo[a] + before * stretch[a];
    // half of the work at the old forces, half at the new ones (final_integrate)
    work -= 0.5 * change / (before + 0.5 * change) * (axis[a].virial - convention * axis[a].kinetic);
  }
  const bool moved = stretch[0] != 1.0 || stretch[1] != 1.0;
  if (moved) {
    domain->set_global_box();
    domain->set_local_box();
  }

  double *const x = atom->x[0];
  const double *const v = atom->v[0];
  const int nlocal = atom->nlocal;
  if (moved) {
    const double lo[2] = {domain->boxlo[0], domain->boxlo[1]};
    const double drift[2] = {0.5 * (1.0 + stretch[0]) * dt, 0.5 * (1.0 + stretch[1]) * dt};
    for (int i = 0; i < 3 * nlocal; i += 3) {
      x[i] = lo[0] + stretch[0] * (x[i] - lo[0]) + drift[0] * v[i];
      x[i + 1] = lo[1] + stretch[1] * (x[i + 1] - lo[1]) + drift[1] * v[i + 1];
    }
  } else {
    for (int i = 0; i < 3 * nlocal; i += 3) {
      x[i] += dt * v[i];
      x[i + 1] += dt * v[i + 1];
    }
  }
}

void FixDiscIntegrate::final_integrate()
{
  const double dt = update->dt;
  kick_grains(0.5 * dt);
  if (!stress_control) return;
  measure_stress();
  for (int a = 0; a < 2; a++) {
    const double now = domain->prd[a];
    const double change = -axis[a].strain_rate * axis[a].start * dt;
    work -= 0.5 * change / (now - 0.5 * change) * (axis[a].virial - convention * axis[a].kinetic);
  }
  kick_cell(0.5 * dt);
}

void FixDiscIntegrate::kick_grains(double dt)
{
  if (drag > 0.0 || convention != 0.0)
    kick<true>(dt);
  else
    kick<false>(dt);
}

/* v += dt F/m, after the factors that drag and convention put on v */
template <bool SCALED> void FixDiscIntegrate::kick(double dt)
{
  double *const v = atom->v[0], *const w = atom->omega[0];
  const double *const f = atom->f[0], *const torque = atom->torque[0];
  const double *const m = atom->rmass, *const r = atom->radius;
  const int nlocal = atom->nlocal;
  const double kept = std::exp(-drag * dt);
  double scale[2] = {1.0, 1.0}, lost = 0.0;
  for (int a = 0; SCALED && a < 2; a++)
    scale[a] = kept * std::exp(-convention * axis[a].strain_rate * axis[a].start / domain->prd[a] * dt);
  for (int i = 0, k = 0; i < nlocal; i++, k += 3) {
    if (SCALED) {
      lost += m[i] * (v[k] * v[k] + v[k + 1] * v[k + 1] + 0.5 * r[i] * r[i] * w[k + 2] * w[k + 2]);
      v[k] *= scale[0];
      v[k + 1] *= scale[1];
      w[k + 2] *= kept;
    }
    const double impulse = dt * inverse[i].mass;
    v[k] += impulse * f[k];
    v[k + 1] += impulse * f[k + 1];
    w[k + 2] += dt * inverse[i].inertia * torque[k + 2];
  }
  if (SCALED) dragged += 0.5 * (1.0 - kept * kept) * lost;
}

void FixDiscIntegrate::kick_cell(double dt)
{
  const double kept = std::exp(-drag * dt);
  for (Axis &a : axis) {
    if (!a.controlled) continue;
    a.strain_rate = kept * a.strain_rate + dt / inertia * (a.target - a.stress);
    if (rate_cap > 0.0) a.strain_rate = std::fmin(std::fmax(a.strain_rate, -rate_cap), rate_cap);
  }
}

/* sigma_aa = (1/A) [sum of m v_a^2 + sum over pairs of F_a r_a] (G07 eq. 3) */
void FixDiscIntegrate::measure_stress()
{
  if (!stress_control) return;
  double sums[4] = {0.0, 0.0, pair->force_moment[0], pair->force_moment[1]};
  const double *const v = atom->v[0], *const m = atom->rmass;
  for (int i = 0; i < atom->nlocal; i++) {
    sums[0] += m[i] * v[3 * i] * v[3 * i];
    sums[1] += m[i] * v[3 * i + 1] * v[3 * i + 1];
  }
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
  double total = dragged;
  MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_DOUBLE, MPI_SUM, world);
  return total;
}

void FixDiscIntegrate::write_restart(FILE *fp)
{
  const double taken = compute_vector(6);    // a sum over ranks: before rank 0 goes its own way
  if (comm->me != 0) return;
  const double state[7] = {
      axis[0].strain_rate, axis[1].strain_rate, axis[0].start, axis[1].start, inertia, work, taken};
  const int size = sizeof(state);
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(state, size, 1, fp);
}

void FixDiscIntegrate::restart(char *buf)
{
  const auto *state = reinterpret_cast<const double *>(buf);
  for (int a = 0; a < 2; a++) {
    axis[a].strain_rate = axis[a].controlled ? state[a] : 0.0;
    axis[a].start = state[2 + a];
  }
  inertia = state[4];
  work = state[5];
  dragged = comm->me == 0 ? state[6] : 0.0;
}
