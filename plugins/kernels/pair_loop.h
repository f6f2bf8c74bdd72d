/* SPDX-License-Identifier: GPL-2.0-or-later
   The loop over the active pairs of discs: gather, compute_forces (the contact law), scatter.

   Stateless: no engine, no history beyond what is passed in.  Units are the caller's.  Signs: n points from i to j, t
   is n rotated by +90 degrees, F_n n + F_t t and a rolling moment M_r are the action of i on j; F_n > 0 repels.
   Relative velocities are those of j minus i, so that vn > 0 separates.  Words and symbols: docs/glossary.md.

   Grains and the forces on them are records (one random access each), pairs are arrays (read in a row), and a block of
   pairs is worked on as arrays, so that one instruction works on several pairs.  Sums run in LANES partial sums
   whatever the instruction set, and nothing is contracted (-ffp-contract=off): every instruction set gives the same
   bits. */

#ifndef DISC_KERNELS_PAIR_LOOP_H
#define DISC_KERNELS_PAIR_LOOP_H

#include "contact_history.h"
#include "simd.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace disc
{

constexpr int LANES = 8;     // pairs in one instruction at most
constexpr int BLOCK = 64;    // pairs in one block: 9 KiB, which stay in the nearest cache

struct alignas(64) Grain {    // one cache line
  double x, y, vx, vy;        // position; velocity beyond the affine motion of the cell
  double w, rw, r;            // angular velocity omega, R omega, radius R
  double inverse_mass;
};

struct alignas(32) GrainForce {    // sums over the pairs of a grain: force, and torque = moment + R tangential
  double fx = 0.0, fy = 0.0, moment = 0.0, tangential = 0.0;
};

/* The pairs that may interact in this step, and a few more.  Arrays end with room for a whole block. */
struct ActivePairs {
  int count = 0;
  std::vector<int> i, j, neighbor;                         // grains; index in the neighbour list
  std::vector<double> pair_constant;                       // what the law computed of the two grains
  std::array<std::vector<double>, MAX_HISTORY> history;    // columns of the law, then empty ones
  int columns = 0;                                         // of the law

  void clear(int history_columns)
  {
    columns = history_columns;
    resize(0);
  }
  void add(int a, int b, int place, double constant, const ContactHistory &h)
  {
    i.push_back(a);
    j.push_back(b);
    neighbor.push_back(place);
    pair_constant.push_back(constant);
    for (int m = 0; m < columns; m++)
      history[m].push_back(h[m]);
    count++;
  }
  void pad() { resize(count + BLOCK); }    // after the last add()
  ContactHistory history_of(int c) const
  {
    ContactHistory h{};
    for (int m = 0; m < columns; m++)
      h[m] = history[m][c];
    return h;
  }

private:
  void resize(int n)
  {
    if (n == 0) count = 0;
    for (auto *list : {&i, &j, &neighbor})
      list->resize(n);
    pair_constant.resize(n);
    for (int m = 0; m < columns; m++)
      history[m].resize(n);
  }
};

/* The step since the last evaluation.  Grains moved by b -> S b + (1 + S)/2 dt v per axis with S the scaling of the
   cell; their mean relative velocity is velocity_factor v + affine_rate b, with b after the step. */
struct StepKinematics {
  double dt = 0.0;    // 0: an evaluation in which no time passes
  // in steps, from the middle of the step that ends here to where dampers act: 1/2 (its end) or 0
  double extrapolation = 0.0;
  double velocity_factor[2] = {1.0, 1.0};
  double affine_rate[2] = {0.0, 0.0};
};

struct PairSums {                                        // of one pass over the pairs
  double xx = 0.0, yy = 0.0, xy = 0.0;                   // F_x b_x, F_y b_y, F_x b_y
  double viscous = 0.0, sliding = 0.0, rolling = 0.0;    // dissipated energy
  double overlap = 0.0, approach = 0.0;                  // largest of any pair, as in Block
};

struct Extremes {           // over the steps so far
  double overlap = 0.0;     // largest R_i + R_j - |b|
  double approach = 0.0;    // fastest approach of two that interact
  double advance = 0.0;     // longest way of such an approach in one step
};

struct Block {
  // in
  alignas(64) double bx[BLOCK], by[BLOCK];    // branch vector b from i to j
  alignas(64) double ux[BLOCK], uy[BLOCK];    // mean relative velocity u = v_j - v_i over the step
  alignas(64) double vt_rot[BLOCK];           // R_i omega_i + R_j omega_j: velocity of the surfaces by rotation
  alignas(64) double omega_rel[BLOCK];        // omega_j - omega_i
  alignas(64) double radsum[BLOCK];           // R_i + R_j
  const double *pair_constant;
  // in and out, in place
  double *history[MAX_HISTORY];
  // out
  alignas(64) double fx[BLOCK], fy[BLOCK];                     // force of i on j
  alignas(64) double tangential[BLOCK], moment[BLOCK];         // F_t, M_r
  alignas(64) double vn_end[BLOCK], contact_changed[BLOCK];    // vn at the end of the step; see missing_share()
  // zero at first: halved for pairs with a ghost even where the law does not fill them
  alignas(64) double dissipated_viscous[BLOCK] = {}, dissipated_sliding[BLOCK] = {}, dissipated_rolling[BLOCK] = {};
  // in and out: the largest so far of the blocks of this pass, place by place
  alignas(64) double overlap[BLOCK] = {};     // R_i + R_j - |b|
  alignas(64) double approach[BLOCK] = {};    // -d|b|/dt of a pair that interacts
};

DISC_INLINE double clamp(double value, double limit)
{
  const double above = value < -limit ? -limit : value;
  return above > limit ? limit : above;
}

/* Coulomb return mapping of a spring: advance the elastic displacement xi, then return to |xi| <= limit.  The energy
   dissipated is the mean of the old and the new force times the slip, which closes the energy balance to second order
   in the step. */
template <bool DISSIPATION>
DISC_INLINE double apply_coulomb_limit(double xi, double increment, double limit, double stiffness, double &dissipated)
{
  const double trial = xi + increment, clamped = clamp(trial, limit);
  if (DISSIPATION) dissipated = 0.5 * stiffness * (xi + clamped) * (trial - clamped);
  return clamped;
}

/* Contact-onset correction.  A force F that sets in, or ends, within a step acts for a fraction q of that step, but
   velocity Verlet gives it one half kick, 1/2 F dt: (q - 1/2) F dt is missing.  The force of an evaluation is applied
   as two half kicks, at the end of this step and the beginning of the next; both together give what is missing, so
   (q - 1/2) F is added to the pairs whose `contact_changed` is set.  FN_DAMP keeps it for the energy account of the
   next step.  Springs grow for the fraction q only.  Such pairs are rare: laws look for them by the block (any) and
   correct them one by one. */
DISC_INLINE double missing_share(double q) { return q - 0.5; }

DISC_INLINE void add(double *__restrict lanes, const double *__restrict a, int count)
{
  for (int k = 0; k < count; k += LANES)
    for (int l = 0; l < LANES; l++)
      lanes[l] += a[k + l];
}

DISC_INLINE void add_products(double *__restrict lanes, const double *__restrict a, const double *__restrict b,
                              int count)
{
  for (int k = 0; k < count; k += LANES)
    for (int l = 0; l < LANES; l++)
      lanes[l] += a[k + l] * b[k + l];
}

DISC_INLINE double total(const double *lanes)
{
  return ((lanes[0] + lanes[1]) + (lanes[2] + lanes[3])) + ((lanes[4] + lanes[5]) + (lanes[6] + lanes[7]));
}

DISC_INLINE bool any(const double *flags, int count)    // flags are 0 or 1
{
  alignas(64) double lanes[LANES] = {};
  add(lanes, flags, count);
  return total(lanes) != 0.0;
}

DISC_INLINE double largest(const double *lanes) { return *std::max_element(lanes, lanes + BLOCK); }

DISC_INLINE void gather(const Grain *grain, const int *i, const int *j, const StepKinematics &step, int count, Block &b)
{
  for (int k = 0; k < count; k += 4) {    // past the end the lists name grain 0
    Vec4 linear[4], angular[4];
    for (int l = 0; l < 4; l++) {
      const Grain &p = grain[i[k + l]], &q = grain[j[k + l]];
      linear[l] = vec4(&q.x) - vec4(&p.x);
      const Vec4 sum = vec4(&q.w) + vec4(&p.w), difference = vec4(&q.w) - vec4(&p.w);
      angular[l] = DISC_SHUFFLE(difference, sum, 0, 5, 6, 7);    // -> omega_rel, vt_rot, radsum, (unused)
    }
    transpose(linear[0], linear[1], linear[2], linear[3]);
    transpose(angular[0], angular[1], angular[2], angular[3]);
    vec4(b.bx + k) = linear[0];
    vec4(b.by + k) = linear[1];
    vec4(b.ux + k) = step.velocity_factor[0] * linear[2] + step.affine_rate[0] * linear[0];
    vec4(b.uy + k) = step.velocity_factor[1] * linear[3] + step.affine_rate[1] * linear[1];
    vec4(b.omega_rel + k) = angular[0];
    vec4(b.vt_rot + k) = angular[1];
    vec4(b.radsum + k) = angular[2];
  }
}

DISC_INLINE void pad(Block &b, int count, int padded)    // far apart and at rest: no force, no dissipation
{
  for (int k = count; k < padded; k++) {
    b.bx[k] = 1.0e100;    // beyond any range, in any units; its square is still finite
    b.by[k] = b.ux[k] = b.uy[k] = b.vt_rot[k] = b.omega_rel[k] = 0.0;
    b.radsum[k] = 1.0e-3;
  }
}

template <class Law> DISC_INLINE void scatter(const Block &b, const int *i, const int *j, int count, GrainForce *force)
{
  for (int k = 0; k < count; k += 4) {
    Vec4 f[4] = {vec4(b.fx + k), vec4(b.fy + k), Vec4{}, Vec4{}};
    if (Law::ROLLING) f[2] = vec4(b.moment + k);
    if (Law::FRICTION) f[3] = vec4(b.tangential + k);
    transpose(f[0], f[1], f[2], f[3]);
    const int last = std::min(4, count - k);
    for (int l = 0; l < last; l++) {
      Vec4 &p = vec4(&force[i[k + l]].fx), &q = vec4(&force[j[k + l]].fx);
      p -= f[l];
      q += f[l] * Vec4{1.0, 1.0, 1.0, -1.0};    // F_t turns both grains the same way (torque -R F_t)
    }
  }
}

/* What a law leaves out is not gathered, computed or scattered.  A law has DAMPING, FRICTION, ROLLING as static
   constants and a member compute_forces<DISSIPATION>(StepKinematics, Block &, count).  count is a multiple of LANES;
   lanes past the last pair are padding: their history is written, and no result depends on it.  Without newton_pair,
   pairs with a ghost (index from nlocal on) are listed on both of their ranks and count half in the sums.  Flags that
   are asked once per block are no template flags: each of those doubles the time to compile. */
template <class Law, bool DISSIPATION>
DISC_WIDEST PairSums pair_loop(const Law &law, const StepKinematics &step, const Grain *grain, int nlocal,
                               bool newton_pair, bool stress, ActivePairs &pairs, GrainForce *force)
{
  alignas(64) double xx[LANES] = {}, yy[LANES] = {}, xy[LANES] = {};
  alignas(64) double viscous[LANES] = {}, sliding[LANES] = {}, rolling[LANES] = {};
  Block b;
  for (int first = 0; first < pairs.count; first += BLOCK) {
    const int count = std::min(BLOCK, pairs.count - first);
    const int padded = (count + LANES - 1) / LANES * LANES;
    const int *const i = &pairs.i[first], *const j = &pairs.j[first];
    b.pair_constant = &pairs.pair_constant[first];
    for (int m = 0; m < pairs.columns; m++)
      b.history[m] = &pairs.history[m][first];

    gather(grain, i, j, step, count, b);
    pad(b, count, padded);
    law.template compute_forces<DISSIPATION>(step, b, padded);
    scatter<Law>(b, i, j, count, force);

    if (!newton_pair)
      for (int k = 0; k < count; k++) {
        if (j[k] < nlocal) continue;
        // halving b halves F b; b is not read again
        for (double *a : {b.bx, b.by, b.dissipated_viscous, b.dissipated_sliding, b.dissipated_rolling})
          a[k] *= 0.5;
      }
    if (stress) {
      add_products(xx, b.fx, b.bx, padded);
      add_products(yy, b.fy, b.by, padded);
      add_products(xy, b.fx, b.by, padded);
    }
    if (DISSIPATION) {
      if (Law::DAMPING) add(viscous, b.dissipated_viscous, padded);
      if (Law::FRICTION) add(sliding, b.dissipated_sliding, padded);
      if (Law::ROLLING) add(rolling, b.dissipated_rolling, padded);
    }
  }
  return {total(xx),      total(yy),      total(xy),          total(viscous),
          total(sliding), total(rolling), largest(b.overlap), largest(b.approach)};
}

}    // namespace disc

#endif
