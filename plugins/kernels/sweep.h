/* SPDX-License-Identifier: GPL-2.0-or-later
   One pass over the close pairs of discs: gather, respond (the contact law), scatter.

   Stateless: no engine, no memory beyond what is passed in.  Units are the caller's.  Signs: n points from i to j, t is
   n rotated by +90 degrees, a force N n + T t and a rolling moment M of i on j; N > 0 repels.

   Grains and what acts on them are records (one random access each), pairs are arrays (read in a row), and a block of
   pairs is worked on as arrays, so that one instruction works on several pairs.  Sums run in LANES partial sums
   whatever the instruction set, and nothing is contracted (-ffp-contract=off): every instruction set gives the same
   bits. */

#ifndef DISC_KERNELS_SWEEP_H
#define DISC_KERNELS_SWEEP_H

#include "four.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace disc
{

constexpr int LANES = 8;     // pairs in one instruction at most
constexpr int BLOCK = 64;    // pairs in one block: 9 KiB, which stay in the nearest cache

struct alignas(64) Grain {    // one cache line
  double x, y, vx, vy;        // position; velocity beyond the affine motion of the cell
  double w, rw, r;            // angular velocity, R w, radius R
  double inverse_mass;
};

struct alignas(32) Action {    // on a grain: force, and torque = moment + R * tangential
  double fx = 0.0, fy = 0.0, moment = 0.0, tangential = 0.0;
};

struct Memory {              // what a pair carries from one evaluation to the next
  double stretch = 0.0;      // elastic part du of the tangential displacement; zero unless in contact
  double rotation = 0.0;     // elastic part dtheta of the relative rotation; zero unless in contact
  double speed = 0.0;        // d|b|/dt in the middle of the last step
  double sideways = 0.0;     // the velocity that tangential damping acts on, in the middle of the last step
  double viscous = 0.0;      // N_v of the last evaluation
  double viscous_t = 0.0;    // T_v and M_v of the dashpots on the tangential and the rolling spring, likewise
  double viscous_r = 0.0;

  bool empty() const
  {
    return stretch == 0.0 && rotation == 0.0 && speed == 0.0 && sideways == 0.0 && viscous == 0.0 && viscous_t == 0.0 &&
           viscous_r == 0.0;
  }
  /* What the other grain remembers; `turned` is the sign of what turns, a moment or an angle. */
  Memory seen_from_other(double turned) const
  {
    return {stretch, turned * rotation, speed, sideways, viscous, viscous_t, turned * viscous_r};
  }
};

struct Contacts {    // the close pairs: all that may act in this step, and a few more; arrays end with room for a whole
                     // block
  int count = 0;
  std::vector<int> i, j, at;                                 // grains; position in the list of neighbours
  std::vector<double> eta;                                   // viscosity
  std::vector<double> stretch, rotation, speed, sideways;    // Memory
  std::vector<double> viscous, viscous_t, viscous_r;         // Memory: N_v, T_v, M_v of the last evaluation

  void clear() { resize(0); }
  void add(int a, int b, int place, double viscosity, const Memory &memory)
  {
    i.push_back(a);
    j.push_back(b);
    at.push_back(place);
    eta.push_back(viscosity);
    stretch.push_back(memory.stretch);
    rotation.push_back(memory.rotation);
    speed.push_back(memory.speed);
    sideways.push_back(memory.sideways);
    viscous.push_back(memory.viscous);
    viscous_t.push_back(memory.viscous_t);
    viscous_r.push_back(memory.viscous_r);
    count++;
  }
  void pad() { resize(count + BLOCK); }    // after the last add()
  Memory memory(int c) const
  {
    return {stretch[c], rotation[c], speed[c], sideways[c], viscous[c], viscous_t[c], viscous_r[c]};
  }

private:
  void resize(int n)
  {
    if (n == 0) count = 0;
    for (auto *list : {&i, &j, &at})
      list->resize(n);
    for (auto *list : {&eta, &stretch, &rotation, &speed, &sideways, &viscous, &viscous_t, &viscous_r})
      list->resize(n);
  }
};

/* What passed since the last evaluation.  Grains moved by b -> S b + (1 + S)/2 dt v per axis with S the stretch of the
   cell; their mean relative velocity is carry v + affine b, with b after the step. */
struct Motion {
  double dt = 0.0;                 // 0: an evaluation in which no time passes
  double ahead = 0.0;              // steps from the middle of the last step to where dampers act
  double carry[2] = {1.0, 1.0};    // see above
  double affine[2] = {0.0, 0.0};
};

struct Sums {                                            // of one sweep
  double xx = 0.0, yy = 0.0, xy = 0.0;                   // F_x b_x, F_y b_y, F_x b_y
  double viscous = 0.0, sliding = 0.0, rolling = 0.0;    // energy dissipated
  double overlap = 0.0, approach = 0.0;                  // largest of any pair, as in Block
};

struct Extremes {           // over the steps so far
  double overlap = 0.0;     // largest R_i + R_j - |b|
  double approach = 0.0;    // fastest approach of two that interact
  double advance = 0.0;     // longest way of such an approach in one step
};

struct Block {
  // in
  alignas(64) double bx[BLOCK], by[BLOCK];    // branch vector from i to j
  alignas(64) double ux[BLOCK], uy[BLOCK];    // mean relative velocity v_j - v_i over the step
  alignas(64) double surface[BLOCK];          // R_i w_i + R_j w_j
  alignas(64) double spin[BLOCK];             // w_j - w_i
  alignas(64) double touch[BLOCK];            // R_i + R_j
  // in and out: memory of the pairs, in place
  const double *eta;
  double *stretch, *rotation, *speed, *sideways, *viscous, *viscous_t, *viscous_r;
  // out
  alignas(64) double fx[BLOCK], fy[BLOCK];    // force of i on j
  alignas(64) double tangential[BLOCK], moment[BLOCK];
  alignas(64) double receding[BLOCK],
      crossed[BLOCK];    // normal velocity; 1 for a pair whose gap changed its sign in the step
  alignas(64) double lost_viscous[BLOCK], lost_sliding[BLOCK], lost_rolling[BLOCK];
  // in and out: the largest so far of the blocks of this sweep, place by place
  alignas(64) double overlap[BLOCK] = {};     // R_i + R_j - |b|
  alignas(64) double approach[BLOCK] = {};    // -d|b|/dt of a pair that interacts
};

/* One slider: advance the elastic displacement, then return to the cone |displacement| <= limit.  The energy lost is
   the mean of the old and the new force times the slip, which closes the energy account to second order in the step. */
template <bool ACCOUNT>
DISC_INLINE double slide(double old, double increment, double limit, double stiffness, double &lost)
{
  const double trial = old + increment;
  const double above = trial < -limit ? -limit : trial;
  const double kept = above > limit ? limit : above;
  if (ACCOUNT) lost = 0.5 * stiffness * (old + kept) * (trial - kept);
  return kept;
}

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

DISC_INLINE double largest(const double *lanes) { return *std::max_element(lanes, lanes + BLOCK); }

/* What a law leaves out is not gathered, computed or scattered.  A law has these as static constants and a member
   respond<ACCOUNT>(Motion, Block &, count).  `halves`: pairs with a grain from `owned` on are listed on both sides.
   What is asked once per block is no template flag: each of those doubles the time to compile. */
template <class Law, bool ACCOUNT>
DISC_WIDEST Sums sweep(const Law &law, const Motion &motion, const Grain *grain, int owned, bool halves, bool stress,
                       Contacts &c, Action *action)
{
  alignas(64) double xx[LANES] = {}, yy[LANES] = {}, xy[LANES] = {};
  alignas(64) double viscous[LANES] = {}, sliding[LANES] = {}, rolling[LANES] = {};
  Block b;
  for (int first = 0; first < c.count; first += BLOCK) {
    const int count = std::min(BLOCK, c.count - first);
    const int whole = (count + LANES - 1) / LANES * LANES;
    const int *const i = &c.i[first], *const j = &c.j[first];
    b.eta = &c.eta[first];
    b.stretch = &c.stretch[first];
    b.rotation = &c.rotation[first];
    b.speed = &c.speed[first];
    b.sideways = &c.sideways[first];
    b.viscous = &c.viscous[first];
    b.viscous_t = &c.viscous_t[first];
    b.viscous_r = &c.viscous_r[first];

    for (int k = 0; k < count; k += 4) {    // past the end the lists name grain 0
      Four move[4], turn[4];
      for (int l = 0; l < 4; l++) {
        const Grain &p = grain[i[k + l]], &q = grain[j[k + l]];
        move[l] = four(&q.x) - four(&p.x);
        const Four sum = four(&q.w) + four(&p.w), difference = four(&q.w) - four(&p.w);
        turn[l] = DISC_PICK(difference, sum, 0, 5, 6, 7);
      }
      transpose(move[0], move[1], move[2], move[3]);
      transpose(turn[0], turn[1], turn[2], turn[3]);
      four(b.bx + k) = move[0];
      four(b.by + k) = move[1];
      four(b.ux + k) = motion.carry[0] * move[2] + motion.affine[0] * move[0];
      four(b.uy + k) = motion.carry[1] * move[3] + motion.affine[1] * move[1];
      four(b.spin + k) = turn[0];
      four(b.surface + k) = turn[1];
      four(b.touch + k) = turn[2];
    }
    for (int k = count; k < whole; k++) {    // far apart and at rest: no force, no loss
      b.bx[k] = 2.0;
      b.by[k] = b.ux[k] = b.uy[k] = b.surface[k] = b.spin[k] = 0.0;
      b.touch[k] = 1.0e-3;
    }

    law.template respond<ACCOUNT>(motion, b, whole);

    for (int k = 0; k < count; k += 4) {
      Four act[4] = {four(b.fx + k), four(b.fy + k), Four{}, Four{}};
      if (Law::ROLLING) act[2] = four(b.moment + k);
      if (Law::FRICTION) act[3] = four(b.tangential + k);
      transpose(act[0], act[1], act[2], act[3]);
      const int last = std::min(4, count - k);
      for (int l = 0; l < last; l++) {
        Four &p = four(&action[i[k + l]].fx), &q = four(&action[j[k + l]].fx);
        p -= act[l];
        q += act[l] * Four{1.0, 1.0, 1.0, -1.0};
      }
    }

    if (halves)
      for (int k = 0; k < count; k++) {
        if (j[k] < owned) continue;
        for (double *a : {b.bx, b.by, b.lost_viscous, b.lost_sliding, b.lost_rolling})
          a[k] *= 0.5;
      }
    if (stress) {
      add_products(xx, b.fx, b.bx, whole);
      add_products(yy, b.fy, b.by, whole);
      add_products(xy, b.fx, b.by, whole);
    }
    if (ACCOUNT) {
      if (Law::DAMPING) add(viscous, b.lost_viscous, whole);
      if (Law::FRICTION) add(sliding, b.lost_sliding, whole);
      if (Law::ROLLING) add(rolling, b.lost_rolling, whole);
    }
  }
  return {total(xx),      total(yy),      total(xy),        total(viscous),
          total(sliding), total(rolling), largest(b.overlap), largest(b.approach)};
}

}    // namespace disc

#endif
