// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/world/triangle_lists.h"
#include "oracles/count_allocations.h"
#include "oracles/meshes.h"
#include "tests/broadphase/world/thread_pool.h"
#include "tests/broadphase/world/twin.h"

#include <algorithm>
#include <array>
#include <latch>
#include <memory>
#include <numeric>
#include <thread>

namespace encage::test {
namespace {

/// All that a search tells: calls of accept, of visit and of ended in their order, and the statistics.
struct Record {
  std::vector<std::pair<Found, std::vector<std::array<int, 2>>>> visits;
  std::vector<Found> accepts;
  std::vector<std::int64_t> counts;
  friend bool operator==(const Record&, const Record&) = default;
};

Record record(World& world, CandidateOptions options, const Executor& executor, bool with_accept = false) {
  Record r;
  options.executor = executor;
  if (with_accept) {
    options.accept = [&](const CandidatePair& pair) {
      EXPECT_TRUE(r.visits.empty());
      r.accepts.push_back(found(pair));
      return (r.accepts.back().a + r.accepts.back().b) % 3 != 0;
    };
  }
  options.ended = [&](const CandidatePair& pair) { r.visits.emplace_back(found(pair), 0); };
  const CandidateStatistics s = world.find_candidates(options, [&](const CandidatePair& pair) {
    auto& triangles = r.visits.emplace_back(found(pair), 0).second;
    for (const TrianglePair t : pair.triangles) triangles.push_back({t.a, t.b});
  });
  r.counts = {s.listed,       s.overlapping,  s.refused,    s.separated[0],
              s.separated[1], s.separated[2], s.candidates, s.asked};
  return r;
}

/// Of two records of the same pairs, whatever they were before.
bool same_candidates(Record a, Record b) {
  for (Record* r : {&a, &b}) {
    for (auto& visit : r->visits) visit.first.what = Found::What::begins;
  }
  return a.visits == b.visits;
}

/// Runs the tasks on the calling thread in another order each time.
Executor shuffled() {
  return {5, [random = std::minstd_rand(7)](int count, TaskRef task) mutable {
            std::vector<int> order(static_cast<std::size_t>(count));
            std::iota(order.begin(), order.end(), 0);
            std::shuffle(order.begin(), order.end(), random);
            for (const int i : order) task(i);
          }};
}

/// A new thread for each task, some late.
Executor new_threads(int threads) {
  return {threads, [](int count, TaskRef task) {
            std::vector<std::jthread> running;
            for (int i = count - 1; i >= 0; --i) {
              running.emplace_back([task, i] {
                for (int k = 0; k < 40 * (i % 3); ++k) std::this_thread::yield();
                task(i);
              });
            }
          }};
}

TEST(WorldThreads, GiveTheSameInTheSameOrderForAnyExecutor) {
  ThreadPool two(2), three(3), seven(7);
  const std::vector<Executor> executors = {two.executor(), three.executor(), seven.executor(),
                                           new_threads(4), shuffled(),       {3, [](int, TaskRef) {}}};
  std::size_t triangles = 0;
  for (unsigned seed = 1; seed <= 2; ++seed) {
    std::vector<std::unique_ptr<Twin>> twins;
    for (std::size_t i = 0; i <= executors.size(); ++i) twins.push_back(std::make_unique<Twin>(seed));
    const auto all = [&](auto&& change) {
      for (const auto& twin : twins) change(*twin);
    };
    std::minstd_rand random(seed);
    for (int i = 0; i < 50; ++i) all([](Twin& twin) { twin.add_body(); });
    for (unsigned step = 0; step < 24; ++step) {
      for (int i = 0; i < 15; ++i)
        all([kind = 1 + static_cast<unsigned>(random() % (Twin::last - 1))](Twin& t) { t.change(kind); });
      if (step % 5 == 0) all([](Twin& twin) { twin.change(0); });
      if (step == 9) all([](Twin& twin) { twin.add_half_space(); });
      CandidateOptions options{.triangles = step % 4 > 1};
      if (step / 6 % 2 == 1) options.pair.margin = 0.2;
      options.pair.cages = step / 12 == 0 ? CageUse::always : CageUse::never;
      const bool with_accept = step % 3 == 1;
      const Record expected = record(twins.back()->world, options, {}, with_accept);
      for (std::size_t i = 0; i < executors.size(); ++i) {
        ASSERT_EQ(record(twins[i]->world, options, executors[i], with_accept), expected)
            << "seed " << seed << ", step " << step << ", executor " << i;
      }
      EXPECT_EQ(with_accept, !expected.accepts.empty());
      for (const auto& visit : expected.visits) triangles += visit.second.size();
    }
  }
  EXPECT_GT(triangles, 10000u);
}

TEST(WorldThreads, WhatHasNoRoomInTheListsComesAllTheSame) {
  constexpr std::size_t room = std::size_t{TriangleLists::block_size} * TriangleLists::block_count;
  CageHierarchy ring;
  ring.fine = shapes::torus(1, 0.4, 24, 12);
  ring.fine.vertices = ring.fine.vertices.cast<float>().eval().cast<double>();
  const auto triangles = static_cast<std::size_t>(ring.fine.triangles.rows());
  World world;
  const ShapeId shape = world.add_shape(make_shape(ring));
  // All triangles of the first two are closer than their margin: more than there is room for. So are, together,
  // those of the others.
  for (int i = 0; i < 2; ++i) world.add_body(shape, shift(0.1 * i), {.margin = 2});
  for (int i = 0; i < 4; ++i) world.add_body(shape, shift(100 + 0.3 * i));
  ASSERT_GT(triangles * triangles, room);
  ThreadPool pool(3);
  const CandidateOptions options{.pair = {.margin = 0.7}, .triangles = true};
  const Record expected = record(world, options, {});
  ASSERT_EQ(expected.visits.front().second.size(), triangles * triangles);
  std::size_t others = 0;
  for (const auto& visit : expected.visits) others += visit.second.size();
  EXPECT_GT(others - triangles * triangles, room);
  EXPECT_TRUE(same_candidates(record(world, options, pool.executor()), expected));
  // Runs nothing but at first, and is then asked about pairs that nobody has looked at.
  const Pose pose = world.motion(BodyId{5}).end;
  world.set_pose(BodyId{5}, shift(0));
  world.set_pose(BodyId{5}, pose);
  int runs = 0;
  const Executor once{2, [&](int, TaskRef task) {
                        if (++runs == 1) task(0);
                      }};
  const Record again = record(world, options, once);
  EXPECT_EQ(runs, 2);
  EXPECT_TRUE(same_candidates(again, expected));
  EXPECT_EQ(again.counts.back(), 3);
}

TEST(WorldThreads, ExceptionsEndTheSearchWhereTheyWould) {
  ThreadPool pool(3);
  const auto throw_first = [](int, TaskRef) { throw std::runtime_error("no threads today"); };
  const auto throw_last = [](int count, TaskRef task) {
    for (int i = 0; i < count; ++i) task(i);
    throw std::runtime_error("too late");
  };
  for (const Executor& executor : {Executor{}, pool.executor(), shuffled()}) {
    Twin twin(5), undisturbed(5);
    for (int i = 0; i < 40; ++i) twin.add_body(), undisturbed.add_body();
    std::vector<Found> seen;
    const auto enough = [&](const CandidatePair& pair) {
      seen.push_back(found(pair));
      if (seen.size() == 9) throw std::runtime_error("enough");
    };
    EXPECT_THROW(twin.world.find_candidates({.triangles = true, .executor = executor}, enough), std::runtime_error);
    EXPECT_THROW(twin.world.find_candidates({.executor = {2, throw_first}}, enough), std::runtime_error);
    const CandidateOptions bad_accept{.accept = [](const CandidatePair& pair) -> bool {
                                        if (pair.a != BodyId{0}) throw std::runtime_error("no");
                                        return true;
                                      },
                                      .executor = executor};
    EXPECT_THROW(twin.world.find_candidates(bad_accept, enough), std::runtime_error);
    EXPECT_EQ(seen.size(), 9u);

    // Nine of the pairs had been asked for sure, and the others not, whoever has already looked.
    const Record expected = record(undisturbed.world, {.triangles = true}, {});
    Record got = record(twin.world, {.triangles = true}, executor);
    ASSERT_TRUE(same_candidates(got, expected));
    for (std::size_t i = 0; i < got.visits.size(); ++i) {
      // What was visited, or about to be, has begun.
      const bool begun = i < seen.size();
      if (begun) {
        EXPECT_EQ(seen[i], expected.visits[i].first);
      }
      EXPECT_EQ(got.visits[i].first.what, begun ? Found::What::persists : Found::What::begins);
    }
    EXPECT_LE(got.counts.back(), expected.counts.back() - 9);
    got.counts.back() = expected.counts.back();
    EXPECT_EQ(got.counts, expected.counts);

    twin.world.set_pose(BodyId{3}, shift(0));
    undisturbed.world.set_pose(BodyId{3}, shift(0));
    EXPECT_THROW(twin.world.find_candidates({.executor = {2, throw_last}}, enough), std::runtime_error);
    EXPECT_TRUE(record(twin.world, {}, executor) == record(undisturbed.world, {}, {}));
  }
}

TEST(WorldThreads, TheCountOfAskedPairsSurvivesAnEndedSearch) {
  ThreadPool pool(2);
  std::vector<std::int64_t> asked;
  for (const Executor& executor : {Executor{}, pool.executor()}) {
    Twin twin(6);
    for (int i = 0; i < 40; ++i) twin.add_body();
    int left = 5;
    const auto visit = [&](const CandidatePair&) {
      if (--left == 0) throw std::runtime_error("enough");
    };
    EXPECT_THROW(twin.world.find_candidates({.executor = executor}, visit), std::runtime_error);
    asked.push_back(record(twin.world, {}, executor).counts.back());
  }
  EXPECT_GT(asked[0], 5);
  EXPECT_EQ(asked[0], asked[1]);
}

TEST(WorldThreads, ANumberOfThreadsHasToBePositive) {
  World world;
  try {
    world.find_candidates({.executor = {.threads = 0}}, [](const CandidatePair&) {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "candidate options: the number of threads 0 is not positive");
  }
}

TEST(WorldThreads, TheWorldIsLockedForWhatTheCallerRuns) {
  World world;
  const ShapeId shape = world.add_shape(sample_shape("box"));
  for (int i = 0; i < 3; ++i) world.add_body(shape, shift(0.1 * i));
  const Executor meddling{2, [&](int count, TaskRef task) {
                            EXPECT_THROW(world.set_pose(BodyId{0}, shift(1)), Error);
                            for (int i = 0; i < count; ++i) task(i);
                          }};
  EXPECT_EQ(record(world, {}, meddling).visits.size(), 3u);
}

TEST(WorldThreads, SearchesDoNotAllocateOnceWarm) {
  ThreadPool pool(3);
  World world;
  const ShapeId shape = world.add_shape(sample_shape("star"));
  std::minstd_rand random(3);
  const auto coordinate = [&] { return 0.01 * static_cast<double>(random() % 400); };
  for (int i = 0; i < 40; ++i) world.add_body(shape, shift(coordinate(), coordinate(), coordinate()));
  const CandidateOptions options{.triangles = true, .executor = pool.executor()};
  std::size_t triangles = 0;
  const auto step = [&](int from) {
    for (std::uint32_t i = 0; i < 40; ++i) {
      const auto body = static_cast<BodyId>(i);
      const Pose start = world.motion(body).end;
      world.set_motion(body, {start, shift(0.2 * (from % 2 == 0 ? 1 : -1), 0.1 * (from % 4 < 2 ? 1 : -1)) * start});
    }
    world.find_candidates(options, [&](const CandidatePair& pair) { triangles += pair.triangles.size(); });
  };
  for (int i = 0; i < 20; ++i) step(i);
  ASSERT_GT(triangles, 100u);
  const long before = allocations;
  for (int i = 0; i < 20; ++i) step(i);
  EXPECT_EQ(allocations, before);
}

// ---- Several threads of the caller's -------------------------------------

TEST(WorldThreads, WorldsThatShareShapesAreIndependent) {
  std::vector<ShapePtr> shapes;
  for (const Sample& s : sample_shapes(0)) shapes.push_back(make_shape(s.hierarchy));
  const auto walk = [&](const Executor& executor) {
    World world;
    std::minstd_rand random(4);
    const auto coordinate = [&] { return 0.01 * static_cast<double>(random() % 500); };
    for (const ShapePtr& shape : shapes) world.add_shape(shape);
    for (int i = 0; i < 30; ++i) {
      world.add_body(static_cast<ShapeId>(i % shapes.size()), shift(coordinate(), coordinate(), coordinate()));
    }
    std::vector<Record> records;
    for (int step = 0; step < 5; ++step) {
      for (int i = 0; i < 10; ++i) {
        world.set_pose(static_cast<BodyId>(random() % 30), shift(coordinate(), coordinate(), coordinate()));
      }
      records.push_back(record(world, {.triangles = true}, executor));
    }
    return records;
  };
  const std::vector<Record> expected = walk({});
  std::array<std::vector<Record>, 4> got;
  {
    std::latch start(4);
    std::vector<std::jthread> threads;
    for (std::size_t t = 0; t < got.size(); ++t) {
      threads.emplace_back([&, t] {
        ThreadPool pool(2);
        start.arrive_and_wait();
        got[t] = walk(t % 2 == 0 ? Executor{} : pool.executor());
      });
    }
  }
  for (const auto& records : got) EXPECT_TRUE(records == expected);
}

TEST(WorldThreads, SeparatedIsReEntrant) {
  struct Question {
    ShapePtr a, b;
    Motion motion;
    double margin;
  };
  std::vector<Question> questions;
  std::vector<ShapePtr> shapes;
  for (const Sample& s : sample_shapes(0)) shapes.push_back(make_shape(s.hierarchy));
  std::minstd_rand random(5);
  const auto coordinate = [&] { return 0.01 * static_cast<double>(random() % 400) - 2; };
  for (int i = 0; i < 400; ++i) {
    const ShapePtr &a = shapes[random() % shapes.size()], &b = shapes[random() % shapes.size()];
    const Pose start = shift(coordinate(), coordinate(), coordinate());
    questions.push_back({a, b, {start, shift(0.1 * (i % 3), 0.05 * (i % 5)) * start}, 0.1 * (i % 2)});
  }
  struct Reply {
    bool separated;
    Stage stage;
    int level;
    std::vector<std::array<int, 2>> triangles;
    bool operator==(const Reply&) const = default;
  };
  const auto reply = [&](const Question& q) {
    const Motion rest;
    const Verdict v = separated(*q.a, rest, *q.b, q.motion, q.margin);
    Reply r{v.separated, v.stage, v.level, {}};
    for_each_triangle_pair(*q.a, rest, *q.b, q.motion, q.margin, [&](TrianglePair t) {
      r.triangles.push_back({t.a, t.b});
      return true;
    });
    const Verdict plane = separated(*q.b, q.motion, HalfSpace{Vector::UnitZ(), -1.5}, q.margin);
    r.triangles.push_back({plane.separated, world_box(*q.b, q.motion).contains(q.motion.end.translation())});
    return r;
  };
  std::vector<Reply> expected;
  for (const Question& q : questions) expected.push_back(reply(q));
  EXPECT_GT(std::count_if(expected.begin(), expected.end(), [](const Reply& r) { return r.separated; }), 50);
  EXPECT_LT(std::count_if(expected.begin(), expected.end(), [](const Reply& r) { return r.separated; }), 350);
  std::array<std::vector<Reply>, 4> got;
  {
    std::latch start(4);
    std::vector<std::jthread> threads;
    for (std::vector<Reply>& replies : got) {
      threads.emplace_back([&] {
        start.arrive_and_wait();
        for (const Question& q : questions) replies.push_back(reply(q));
      });
    }
  }
  for (const auto& replies : got) EXPECT_TRUE(replies == expected);
}

}  // namespace
}  // namespace encage::test
