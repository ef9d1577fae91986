#include <gtest/gtest.h>
#include <chrono>
#include <cstdio>
#include "omniflight_proof/plant.hpp"
using namespace omniflight;
TEST(Nominal, X) {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  auto v = vehicle::load_vehicle("omnimorph");
  ASSERT_TRUE(v) << v.error().text();
  for (int c = 0; c < 2; ++c) {
    proof::World w;
    if (c) w.cable.emplace();
    proof::PlantOptions o;
    o.initial.p_WB = Vec3(0, 0, 1.3);
    auto t00 = std::chrono::steady_clock::now();
    auto p = proof::MujocoPlant::create(*v, w, o);
    ASSERT_TRUE(p) << p.error().text();
    std::printf("create %g\n", std::chrono::duration<double>(std::chrono::steady_clock::now() - t00).count());
    auto t0 = std::chrono::steady_clock::now();
    for (int i = 0; i < 1000; ++i) ASSERT_TRUE(p->step(true));
    std::printf("held 1 s %g, force %g kg %g\n",
                std::chrono::duration<double>(std::chrono::steady_clock::now() - t0).count(),
                p->cable_force_W().z() / kGravity, 0.15 * (1.3 - .12));
    for (auto& x : p->cable_shape()) std::printf("(%.3f %.3f %.3f)", x.x(), x.y(), x.z());
    puts("");
    t0 = std::chrono::steady_clock::now();
    for (int i = 0; i < 500; ++i) ASSERT_TRUE(p->step());
    std::printf("free .5 s %g z %g expect %g\n",
                std::chrono::duration<double>(std::chrono::steady_clock::now() - t0).count(),
                p->body().p_WB.z(), 1.3 - 9.81 / 8);
  }
}
