/* Random pairs through every kernel of the cohesive law; prints the bytes of what comes out, and in the last line what
   lanes without a pair add to the virial. */

#include "kernels/time_integration.h"
#include "kernels/cohesive.h"

#include <cstdio>
#include <random>

using namespace disc;

template <class T> void print(const std::vector<T> &list)
{
  const auto *bytes = reinterpret_cast<const unsigned char *>(list.data());
  for (size_t k = 0; k < list.size() * sizeof(T); k++)
    std::printf("%02x", bytes[k]);
  std::printf("\n");
}

template <bool SECOND, bool COHESION, bool ROLLING> void run()
{
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  CohesiveLaw law;
  law.kn = law.kt = 1e4;
  law.zeta = 0.8;
  law.mu = 0.3;
  law.f0 = COHESION ? 1.0 : 0.0;
  law.d0 = 0.02;
  law.kr = 1.0;
  law.mur = 0.01;
  const int count = 201;    // no whole number of blocks or lanes
  std::vector<Grain> grains;
  std::vector<GrainForce> forces(2 * count);
  std::vector<Inertia> inertia;
  ActivePairs active;
  active.clear(CohesiveHistory::COUNT);
  for (int k = 0; k < count; k++) {
    const double angle = 3.0 * unit(random), distance = 1.0 + 0.02 * unit(random);    // about half overlap
    for (int side = 0; side < 2; side++) {
      const double w = unit(random), r = 0.5;
      grains.push_back({3.0 * k + side * distance * std::cos(angle), side * distance * std::sin(angle), unit(random),
                        unit(random), w, r * w, r, 1.0});
      inertia.push_back({1.0, 8.0});
    }
    active.add(2 * k, 2 * k + 1, k, 40.0, {1e-4 * unit(random), 1e-4 * unit(random), unit(random)});
  }
  active.pad();
  StepKinematics kinematics;
  kinematics.dt = 1e-3;
  kinematics.extrapolation = 0.5;
  kinematics.affine_rate[0] = 0.1;
  const Cohesive<SECOND, true, COHESION, true, ROLLING> kernel{law};
  std::vector<double> sums;
  for (int step = 0; step < 20; step++) {
    const PairSums s = pair_loop<decltype(kernel), true>(kernel, kinematics, grains.data(), 2 * count, true, true,
                                                         active, forces.data());
    sums.insert(sums.end(), {s.xx, s.yy, s.xy, s.viscous, s.sliding, s.rolling});
    HalfKick kick;
    kick.dt = 0.5 * kinematics.dt;
    Drift drift;
    drift.dt[0] = drift.dt[1] = kinematics.dt;
    const StepSums p =
        integrate<true, true, false, true, false>(kick, drift, inertia.data(), forces.data(), grains.data(), 2 * count);
    sums.insert(sums.end(), {p.mvx2, p.mvy2, p.max_displacement_sq, p.displacement_sq_sum});
  }
  print(sums);
  print(grains);
  print(active.history[CohesiveHistory::XI_T]);
  print(active.history[CohesiveHistory::XI_R]);
}

/* One pair and seven lanes of padding, any range of attraction: virial of the pass over that of the pair, F b. */
double virial_ratio(double range)
{
  CohesiveLaw law;
  law.kn = law.f0 = 1.0;
  law.d0 = range;
  const std::vector<Grain> grains = {{0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 1.0},
                                     {1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 1.0}};
  std::vector<GrainForce> forces(2);
  ActivePairs active;
  active.clear(CohesiveHistory::COUNT);
  active.add(0, 1, 0, 1.0, {});
  active.pad();
  const Cohesive<true, true, true, true, true> kernel{law};
  const PairSums s =
      pair_loop<decltype(kernel), true>(kernel, StepKinematics(), grains.data(), 2, true, true, active, forces.data());
  return s.xx / (1.5 * forces[1].fx);
}

int main()
{
  run<true, true, true>();
  run<true, false, false>();
  run<false, true, true>();
  run<false, false, false>();
  std::printf("%.17g %.17g %.17g\n", virial_ratio(1.0), virial_ratio(10.0), virial_ratio(1e9));
}
