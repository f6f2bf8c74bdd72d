/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_disc_equilibrium.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "keywords.h"
#include "modify.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <unistd.h>

using namespace LAMMPS_NS;

FixDiscEquilibrium::FixDiscEquilibrium(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg), pairs(lmp)
{
  scalar_flag = vector_flag = 1;
  size_vector = QUANTITIES;
  extscalar = extvector = 0;
  restart_global = 1;
  comm_forward = comm_reverse = 1;
  if (narg < 4) error->all(FLERR, "fix disc/equilibrium needs the interval N between checks, in steps");
  nevery = utils::inumeric(FLERR, arg[3], false, lmp);
  if (nevery < 1) error->all(FLERR, "fix disc/equilibrium: interval N = {} must be at least 1", nevery);
  global_freq = nevery;

  keywords().parse(4, narg, arg);
  check();
}

Keywords FixDiscEquilibrium::keywords()
{
  return {lmp,
          "fix disc/equilibrium",
          {number("unit", unit),
           number("length", length),
           {"stress", 2, "S_x and S_y (a number or NULL)", [this](LAMMPS *, char **value) { set_stress(value); }},
           number("hold", hold),
           number("force", force_tolerance),
           number("energy", energy_tolerance),
           number("share", share),
           {"stop", 1, "a file", [this](LAMMPS *, char **value) { stop_file = value[0]; }},
           logical("aggregates", aggregates)}};
}

void FixDiscEquilibrium::check() const
{
  const std::pair<const char *, double> values[] = {
      {"unit", unit},  {"length", length}, {"hold", hold}, {"force", force_tolerance}, {"energy", energy_tolerance},
      {"share", share}};
  for (const auto &[name, value] : values)
    if (value < 0.0) error->all(FLERR, "fix disc/equilibrium: {} = {} must not be negative", name, value);
  if (unit <= 0.0)
    error->all(FLERR, "fix disc/equilibrium: keyword 'unit' (force F1 = max(F0, P a)) must be given and positive");
}

void FixDiscEquilibrium::set_stress(char **value)
{
  for (int a = 0; a < 2; a++) {
    controlled[a] = strcmp(value[a], "NULL") != 0;
    target[a] = controlled[a] ? utils::numeric(FLERR, value[a], false, lmp) : 0.0;
  }
}

int FixDiscEquilibrium::modify_param(int narg, char **arg)
{
  if (strcmp(arg[0], "stress") != 0) return 0;
  held_since = -1.0;
  network_changed = now();
  return keywords().parse_one(0, narg, arg);
}

int FixDiscEquilibrium::setmask() { return FixConst::END_OF_STEP; }

void FixDiscEquilibrium::init()
{
  pairs.init("fix disc/equilibrium");
  if (aggregates && atom->map_style == Atom::MAP_NONE)
    error->all(FLERR, "fix disc/equilibrium: 'aggregates yes' needs 'atom_modify map array' or 'map hash'");
}

/* The clocks go on: through stages, and from a checkpoint; a new stress starts them again. */
void FixDiscEquilibrium::setup(int)
{
  measure();
  quantity[HELD] = held_since < 0.0 ? 0.0 : now() - held_since;
}

double FixDiscEquilibrium::now() const
{
  return update->atime + update->dt * static_cast<double>(update->ntimestep - update->atimestep);
}

void FixDiscEquilibrium::end_of_step()
{
  measure();
  if (!within_tolerance())
    held_since = -1.0;
  else if (held_since < 0.0)
    held_since = now();
  quantity[HELD] = held_since < 0.0 ? 0.0 : now() - held_since;
}

void FixDiscEquilibrium::measure()
{
  double stress[2];
  measure_pairs(stress);
  measure_grains(stress);
  monitor_network();
  if (aggregates) count_aggregates();
  double stop = 0.0;
  if (comm->me == 0 && !stop_file.empty() && access(stop_file.c_str(), F_OK) == 0) stop = 1.0;
  MPI_Bcast(&stop, 1, MPI_DOUBLE, 0, world);
  quantity[STOP] = stop;
}

bool FixDiscEquilibrium::supports_grain(const PairDisc::Interaction &now) const
{
  return pairs.cutoff_gap() > 0.0 || now.elastic > force_tolerance * unit;
}

double FixDiscEquilibrium::needed_supports() const { return pairs.cutoff_gap() > 0.0 ? 1.0 : 2.0; }

/* A grain is unsupported if nothing holds it: without cohesion, fewer than two contacts with an elastic force above the
   tolerance; with cohesion, no interaction at all.  Counted once: a grain that unsupported ones alone hold is supported
   here, while the rattlers of `wf measure` are found recursively. */
void FixDiscEquilibrium::measure_pairs(double *stress)
{
  const bool newton = force->newton_pair;
  const int nlocal = atom->nlocal;
  double sums[4] = {0.0, 0.0, 0.0, 0.0}, largest[2] = {0.0, 0.0};
  supports.assign(nlocal + atom->nghost, 0.0);
  pairs.refresh();
  pairs.for_each_pair([&](int i, int j, const PairDisc::Interaction &now, double weight) {
    sums[0] += weight * now.fx() * now.bx;
    sums[1] += weight * now.fy() * now.by;
    sums[now.state == PairDisc::CONTACT ? 2 : 3] += weight;
    if (supports_grain(now)) {
      supports[i] += 1.0;
      if (newton || j < nlocal) supports[j] += 1.0;
    }
    largest[0] = std::max(largest[0], -now.gap);
    largest[1] = std::max(largest[1], pairs.approach(i, j, now));
  });
  if (newton) comm->reverse_comm(this, 1);
  MPI_Allreduce(MPI_IN_PLACE, sums, 4, MPI_DOUBLE, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, largest, 2, MPI_DOUBLE, MPI_MAX, world);
  stress[0] = sums[0];
  stress[1] = sums[1];
  quantity[CONTACTS] = sums[2];
  quantity[DISTANT] = sums[3];
  quantity[OVERLAP] = largest[0];
  quantity[APPROACH] = largest[1];
  if (!pairs.ours()) return;
  const auto *history = dynamic_cast<FixDiscHistory *>(modify->get_fix_by_id(FixDiscHistory::ID));
  const disc::Extremes extremes = history->state.global_extremes();
  quantity[LARGEST_OVERLAP] = extremes.overlap;
  quantity[LARGEST_APPROACH] = extremes.approach;
  quantity[LARGEST_ADVANCE] = extremes.advance;
}

void FixDiscEquilibrium::measure_grains(const double *virial)
{
  double largest[2] = {0.0, 0.0};
  enum { MASS, PX, PY, ENERGY, COUNT, SUPPORTED, RAW, MVX2, MVY2, SUMS };
  double sums[SUMS] = {};
  for (int i = 0; i < atom->nlocal; i++) {
    const double *f = atom->f[i], *v = atom->v[i];
    const double m = atom->rmass[i], r = atom->radius[i], w = atom->omega[i][2];
    largest[0] = std::max(largest[0], f[0] * f[0] + f[1] * f[1]);
    largest[1] = std::max(largest[1], std::fabs(atom->torque[i][2]));
    const double energy = 0.5 * m * (v[0] * v[0] + v[1] * v[1]) + 0.25 * m * r * r * w * w;
    sums[RAW] += energy;
    sums[MVX2] += m * v[0] * v[0];
    sums[MVY2] += m * v[1] * v[1];
    const bool supported = supports[i] >= needed_supports();
    if (supported) sums[SUPPORTED] += 1.0;
    if (!supported && pairs.cutoff_gap() == 0.0) continue;
    sums[MASS] += m;
    sums[PX] += m * v[0];
    sums[PY] += m * v[1];
    sums[ENERGY] += energy;
    sums[COUNT] += 1.0;
  }
  MPI_Allreduce(MPI_IN_PLACE, sums, SUMS, MPI_DOUBLE, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, largest, 2, MPI_DOUBLE, MPI_MAX, world);
  const double grains = static_cast<double>(atom->natoms);
  const double drift = sums[MASS] > 0.0 ? 0.5 * (sums[PX] * sums[PX] + sums[PY] * sums[PY]) / sums[MASS] : 0.0;
  const double area = domain->prd[0] * domain->prd[1];
  quantity[FORCE] = std::sqrt(largest[0]);
  quantity[MOMENT] = largest[1];
  quantity[STRESS_X] = (virial[0] + sums[MVX2]) / area;
  quantity[STRESS_Y] = (virial[1] + sums[MVY2]) / area;
  quantity[KINETIC] = sums[COUNT] > 0.0 ? (sums[ENERGY] - drift) / sums[COUNT] : sums[RAW] / grains;
  quantity[KINETIC_RAW] = sums[RAW] / grains;
  quantity[UNSUPPORTED] = grains - sums[SUPPORTED];
  const double pair_stress[2] = {virial[0] / area, virial[1] / area};
  quantity[STRESS_ERROR] = stress_error(pair_stress);
}

/* Without cohesion the light contacts of an unsupported grain come and go; what holds the packing carries forces of
   order F1, and a hundred tolerances is far below that. */
void FixDiscEquilibrium::monitor_network()
{
  const double least = pairs.cutoff_gap() > 0.0 ? 0.0 : 100.0 * force_tolerance * unit;
  comm->forward_comm(this, 1);
  uint64_t sum = 0;
  pairs.for_each_pair([&](int i, int j, const PairDisc::Interaction &now, double) {
    if (now.state != PairDisc::CONTACT || now.elastic < least) return;
    if (supports[i] < needed_supports() || supports[j] < needed_supports()) return;
    const uint64_t a = std::min(atom->tag[i], atom->tag[j]), b = std::max(atom->tag[i], atom->tag[j]);
    uint64_t hash = (a << 32 | b) * 0x9E3779B97F4A7C15ull;    // multiplicative hash, mixed once more
    sum += (hash ^ hash >> 29) * 0xBF58476D1CE4E5B9ull;
  });
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, world);
  if (sum != network) network_changed = now();
  network = sum;
  quantity[SINCE_CHANGE] = now() - network_changed;
}

/* Every grain gets the smallest tag of its aggregate.  A rank joins what it sees; where an aggregate reaches over to
   other ranks, labels travel to the owners of ghosts and back until none changes: as often as it crosses a border. */
void FixDiscEquilibrium::label_aggregates()
{
  const int nlocal = atom->nlocal, nall = nlocal + atom->nghost;
  std::vector<int> root(nall);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&root](int i) {
    while (root[i] != i)
      i = root[i] = root[root[i]];
    return i;
  };
  for (int i = nlocal; i < nall; i++) {    // images of one grain are one
    const int owner = atom->map(atom->tag[i]);
    root[find(i)] = find(owner);
  }
  pairs.for_each_pair([&](int i, int j, const PairDisc::Interaction &, double) { root[find(i)] = find(j); });

  label.resize(nall);
  for (int i = 0; i < nall; i++)
    label[i] = atom->tag[i];
  labelling = true;
  int changed = 1;
  while (changed) {
    changed = 0;
    for (int i = 0; i < nall; i++) {
      double &smallest = label[find(i)];
      if (label[i] >= smallest) continue;
      smallest = label[i];
      changed = 1;    // news for other ranks even where every other label of the set knew it
    }
    for (int i = 0; i < nall; i++) {
      const double smallest = label[find(i)];
      if (label[i] != smallest) changed = 1;
      label[i] = smallest;
    }
    if (comm->nprocs == 1) break;    // the images were joined above
    comm->reverse_comm(this, 1);
    comm->forward_comm(this, 1);
    MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPI_INT, MPI_MAX, world);
  }
  labelling = false;
}

void FixDiscEquilibrium::count_aggregates()
{
  label_aggregates();
  std::vector<int> size(atom->map_tag_max + 1, 0);
  for (int i = 0; i < atom->nlocal; i++)
    size[static_cast<tagint>(label[i])]++;
  if (comm->nprocs > 1) MPI_Allreduce(MPI_IN_PLACE, size.data(), size.size(), MPI_INT, MPI_SUM, world);
  const double count = size.size() - std::count(size.begin(), size.end(), 0);
  if (aggregate_count >= 0.0 && count != aggregate_count) network_changed = now();
  quantity[AGGREGATES] = aggregate_count = count;
  quantity[SINCE_CHANGE] = now() - network_changed;
  quantity[LARGEST_AGGREGATE] = *std::max_element(size.begin(), size.end());
}

bool FixDiscEquilibrium::within_tolerance() const
{
  return quantity[STRESS_ERROR] < 1.0 && quantity[FORCE] < force_tolerance * unit &&
         quantity[MOMENT] < force_tolerance * unit * length && quantity[KINETIC] < energy_tolerance * unit * length;
}

double FixDiscEquilibrium::stress_error(const double *pair_stress) const
{
  double largest = 0.0;
  for (int a = 0; a < 2; a++) {
    if (!controlled[a]) continue;
    double tolerance = force_tolerance * unit / length;
    if (target[a] != 0.0) tolerance = std::min(tolerance, share * std::fabs(target[a]));
    for (const double stress : {pair_stress[a], quantity[STRESS_X + a]})
      largest = std::max(largest, std::fabs(stress - target[a]) / tolerance);
  }
  return largest;
}

double FixDiscEquilibrium::compute_scalar() { return held_since >= 0.0 && quantity[HELD] >= hold ? 1.0 : 0.0; }

double FixDiscEquilibrium::compute_vector(int n) { return quantity[n]; }

int FixDiscEquilibrium::pack_forward_comm(int n, int *list, double *buf, int, int *)
{
  const std::vector<double> &value = labelling ? label : supports;
  for (int k = 0; k < n; k++)
    buf[k] = value[list[k]];
  return n;
}

void FixDiscEquilibrium::unpack_forward_comm(int n, int first, double *buf)
{
  std::copy(buf, buf + n, (labelling ? label : supports).begin() + first);
}

int FixDiscEquilibrium::pack_reverse_comm(int n, int first, double *buf)
{
  const auto from = (labelling ? label : supports).begin() + first;
  std::copy(from, from + n, buf);
  return n;
}

void FixDiscEquilibrium::unpack_reverse_comm(int n, int *list, double *buf)
{
  for (int k = 0; k < n; k++)
    if (labelling)
      label[list[k]] = std::min(label[list[k]], buf[k]);
    else
      supports[list[k]] += buf[k];
}

void FixDiscEquilibrium::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  const int size = 3 * sizeof(double) + sizeof(network);
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(&held_since, sizeof(held_since), 1, fp);
  fwrite(&network_changed, sizeof(network_changed), 1, fp);
  fwrite(&network, sizeof(network), 1, fp);
  fwrite(&aggregate_count, sizeof(aggregate_count), 1, fp);
}

void FixDiscEquilibrium::restart(char *buf)
{
  memcpy(&held_since, buf, sizeof(held_since));
  memcpy(&network_changed, buf + sizeof(held_since), sizeof(network_changed));
  memcpy(&network, buf + sizeof(held_since) + sizeof(network_changed), sizeof(network));
  memcpy(&aggregate_count, buf + sizeof(held_since) + sizeof(network_changed) + sizeof(network),
         sizeof(aggregate_count));
}
