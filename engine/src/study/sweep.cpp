#include "bgsim/sweep.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <mutex>
#include <thread>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/text.hpp"

namespace bgsim {

namespace {

/// What a scene's run is with the values of one point.
class Worker {
 public:
  Worker(const Simulation& scene, const std::string& name, const SceneOverrides& overrides, const SweepPoints& points,
         const SweepResults& results, const SweepOptions& options)
      : scene_(scene), name_(name), overrides_(overrides), points_(points), results_(results), how_(options.how) {
    how_.measures = true;
    how_.rows = {};
    how_.remark = {};
    how_.progress = options.goes_on ? Progress([&options](double) { return options.goes_on(); }) : Progress{};
  }

  struct Done {
    SweepRun run;
    RunResult result;
  };

  Done make(std::uint64_t index) const {
    Done done;
    done.run.index = index;
    done.run.values = points_.at(index);
    try {
      const RunInputs inputs = inputs_with(done.run.values);
      done.result = scene_.simulate(inputs, how_);
      if (done.result.stop == StopReason::completed) {
        take_results(done, inputs);
      } else if (done.result.failure) {
        done.run.message = done.result.failure->code + ": " + done.result.failure->situation;
      }
    } catch (const ModelError& error) {
      done.result.stop = StopReason::failed;
      done.run.message = error.diagnostics.front().code + ": " + error.diagnostics.front().situation;
    }
    return done;
  }

 private:
  RunInputs inputs_with(const std::vector<double>& values) const {
    SceneOverrides overrides = overrides_;
    std::optional<double> start, stop;
    const std::vector<Variation>& variations = points_.plan().variations;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::string& target = variations[i].name;
      if (target == "scene.start")
        start = values[i];
      else if (target == "scene.stop")
        stop = values[i];
      else if (target == "scene.relative")
        overrides.relative = values[i];
      else if (target == "scene.absolute")
        overrides.absolute = values[i];
      else if (target == "scene.step")
        overrides.step = values[i];
      else
        overrides.set.push_back(target + "=" + shortest_number(values[i]));
    }
    RunInputs inputs = prepare_scene(scene_.model(), name_, overrides);
    if (!start && !stop) return inputs;
    inputs.start = start.value_or(inputs.start);
    inputs.stop = stop.value_or(inputs.stop);
    if (inputs.stop < inputs.start)
      throw ModelError({diagnostic_of("BG143", "the scene stops at " + number_text(inputs.stop) +
                                                   ", before its start at " + number_text(inputs.start))},
                       scene_.model().sources);
    const std::size_t count = inputs.stop > inputs.start ? inputs.output_times.size() : 1;
    inputs.output_times = OutputTimes::equidistant(inputs.start, inputs.stop, std::max<std::size_t>(count, 1));
    return inputs;
  }

  void take_results(Done& done, const RunInputs& inputs) const {
    const RunReport& report = done.result.report;
    if (report.measures.empty()) {
      done.run.message = "an output has no value within the run: " + report.why_not_measured;
      done.result.stop = StopReason::failed;
      return;
    }
    done.run.results = results_.of(done.result, inputs, done.run.notes);
    done.run.completed = true;
    done.run.notes.insert(done.run.notes.end(), report.notes.begin(), report.notes.end());
    for (const Diagnostic& warning : inputs.warnings) done.run.notes.push_back(warning.code + ": " + warning.situation);
  }

  const Simulation& scene_;
  const std::string& name_;
  const SceneOverrides& overrides_;
  const SweepPoints& points_;
  const SweepResults& results_;
  SimulateOptions how_;
};

}  // namespace

void sweep(const Simulation& scene, const std::string& name, const SceneOverrides& overrides, const SweepPoints& points,
           const SweepResults& results, const SweepOptions& options) {
  const Worker worker(scene, name, overrides, points, results, options);
  std::mutex mutex;
  std::exception_ptr thrown;
  std::atomic<bool> ended = false;
  const auto goes_on = [&] { return !ended && (!options.goes_on || options.goes_on()); };
  const auto work = [&] {
    constexpr std::chrono::duration<double> kChunk(0.2);
    std::size_t chunk = 1;
    std::vector<std::uint64_t> indices;
    std::vector<Worker::Done> done;
    try {
      while (goes_on()) {
        indices.clear();
        {
          const std::scoped_lock lock(mutex);
          while (indices.size() < chunk) {
            const auto next = options.next();
            if (!next) break;
            indices.push_back(*next);
          }
        }
        if (indices.empty()) return;
        done.clear();
        const auto begin = std::chrono::steady_clock::now();
        for (const std::uint64_t index : indices) {
          if (!goes_on()) break;
          Worker::Done one = worker.make(index);
          if (one.result.stop != StopReason::interrupted) done.push_back(std::move(one));
        }
        const std::chrono::duration<double> each =
            (std::chrono::steady_clock::now() - begin) / static_cast<double>(indices.size());
        constexpr double kMost = 1000.0;
        chunk = static_cast<std::size_t>(std::clamp(kChunk / std::max(each, kChunk / kMost), 1.0, kMost));
        const std::scoped_lock lock(mutex);
        for (const Worker::Done& one : done) options.done(one.run, one.result);
      }
    } catch (...) {
      const std::scoped_lock lock(mutex);
      if (!thrown) thrown = std::current_exception();
      ended = true;
    }
  };
  std::vector<std::thread> threads;
  for (unsigned i = 1; i < options.threads; ++i) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace bgsim
