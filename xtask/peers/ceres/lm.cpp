// Ceres on the tracker problem: lm FOLDER THREADS RUNS INITIAL_RADIUS LEAST_GAIN
//
// One residual block per station and step with the ranges to all targets, and one per step with the
// distances between them. Parameter blocks: the targets of a step, and of each station its free
// coordinates together with its dead paths; one with all distances. DENSE_SCHUR eliminates the
// targets first; derivatives are by hand. The search ends with the first step that gains less than
// LEAST_GAIN of the cost and keeps it, or below 1e-10 of it, where Ceres throws the step away.
// Prints a line of JSON per run, with the most memory that the process has had so far; the solution
// goes to ceres.bin beside the problem. With --version it prints that of Ceres.
#include <ceres/ceres.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <deque>
#include <fstream>
#include <string>
#include <vector>

namespace {

std::vector<double> Read(const std::string& path) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  std::vector<double> numbers(static_cast<size_t>(in.tellg()) / sizeof(double));
  in.seekg(0);
  in.read(reinterpret_cast<char*>(numbers.data()), numbers.size() * sizeof(double));
  return numbers;
}

double Distance(const double* a, const double* b, double* cosines) {
  double squares = 0.0;
  for (int c = 0; c < 3; ++c) {
    cosines[c] = a[c] - b[c];
    squares += cosines[c] * cosines[c];
  }
  const double distance = std::sqrt(squares);
  for (int c = 0; c < 3; ++c) cosines[c] /= distance;
  return distance;
}

// Ranges from one station, of which the first F coordinates are free, to the J targets of a step.
// Its parameters are those coordinates and then its dead paths.
template <int I, int J, int F>
class Ranges : public ceres::SizedCostFunction<J, 3 * J, F + J> {
 public:
  explicit Ranges(const double* displacements) : displacements_(displacements) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    double station[3] = {0.0, 0.0, 0.0};
    for (int c = 0; c < F; ++c) station[c] = x[1][c];
    double* by_targets = jacobians == nullptr ? nullptr : jacobians[0];
    double* by_station = jacobians == nullptr ? nullptr : jacobians[1];
    if (by_targets != nullptr) std::fill_n(by_targets, 3 * J * J, 0.0);
    if (by_station != nullptr) std::fill_n(by_station, (F + J) * J, 0.0);
    for (int j = 0; j < J; ++j) {
      double cosines[3];
      const double range = Distance(x[0] + 3 * j, station, cosines);
      residuals[j] = range - displacements_[j * I] - x[1][F + j];
      if (by_targets != nullptr) {
        for (int c = 0; c < 3; ++c) by_targets[3 * J * j + 3 * j + c] = cosines[c];
      }
      if (by_station != nullptr) {
        for (int c = 0; c < F; ++c) by_station[(F + J) * j + c] = -cosines[c];
        by_station[(F + J) * j + F + j] = -1.0;
      }
    }
    return true;
  }

 private:
  const double* displacements_;
};

// Distances between the targets of a step.
template <int J>
class Rigid : public ceres::SizedCostFunction<J*(J - 1) / 2, 3 * J, J*(J - 1) / 2> {
 public:
  static constexpr int kPairs = J * (J - 1) / 2;

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    double* by_targets = jacobians == nullptr ? nullptr : jacobians[0];
    double* by_distances = jacobians == nullptr ? nullptr : jacobians[1];
    if (by_targets != nullptr) std::fill_n(by_targets, 3 * J * kPairs, 0.0);
    if (by_distances != nullptr) std::fill_n(by_distances, kPairs * kPairs, 0.0);
    int n = 0;
    for (int a = 0; a < J; ++a) {
      for (int b = a + 1; b < J; ++b, ++n) {
        double cosines[3];
        residuals[n] = Distance(x[0] + 3 * a, x[0] + 3 * b, cosines) - x[1][n];
        if (by_targets != nullptr) {
          for (int c = 0; c < 3; ++c) {
            by_targets[3 * J * n + 3 * a + c] = cosines[c];
            by_targets[3 * J * n + 3 * b + c] = -cosines[c];
          }
        }
        if (by_distances != nullptr) by_distances[kPairs * n + n] = -1.0;
      }
    }
    return true;
  }
};

// Parameter blocks and cost functions, which the problem points into.
template <int I, int J>
struct Scene {
  static constexpr int kPairs = J * (J - 1) / 2;

  int steps;
  std::vector<double> stations[I];
  std::vector<double> distances;
  std::vector<double> targets;
  std::deque<Ranges<I, J, 0>> from_origin;
  std::deque<Ranges<I, J, 1>> from_line;
  std::deque<Ranges<I, J, 2>> from_plane;
  std::deque<Ranges<I, J, 3>> from_space;
  Rigid<J> rigid;

  Scene(const std::vector<double>& start, int steps) : steps(steps) {
    for (int i = 0; i < I; ++i) {
      const double* dead_paths = &start[3 * I + i * J];
      stations[i].assign(&start[3 * i], &start[3 * i] + std::min(i, 3));
      stations[i].insert(stations[i].end(), dead_paths, dead_paths + J);
    }
    const auto shared = start.begin() + 3 * I + I * J;
    distances.assign(shared, shared + kPairs);
    targets.assign(shared + kPairs, start.end());
  }

  template <int F>
  void Add(std::deque<Ranges<I, J, F>>& costs, int i, const double* displacements, int k,
           ceres::Problem& problem) {
    costs.emplace_back(displacements + I * J * k + i);
    problem.AddResidualBlock(&costs.back(), nullptr, &targets[3 * J * k], stations[i].data());
  }

  void Build(const double* displacements, ceres::Problem& problem) {
    for (int k = 0; k < steps; ++k) {
      Add<0>(from_origin, 0, displacements, k, problem);
      Add<1>(from_line, 1, displacements, k, problem);
      Add<2>(from_plane, 2, displacements, k, problem);
      for (int i = 3; i < I; ++i) Add<3>(from_space, i, displacements, k, problem);
      problem.AddResidualBlock(&rigid, nullptr, &targets[3 * J * k], distances.data());
    }
  }

  std::vector<double> Solution(std::vector<double> numbers) const {
    for (int i = 0; i < I; ++i) {
      const auto dead_paths = stations[i].begin() + std::min(i, 3);
      std::copy(stations[i].begin(), dead_paths, &numbers[3 * i]);
      std::copy(dead_paths, stations[i].end(), &numbers[3 * I + i * J]);
    }
    std::copy(distances.begin(), distances.end(), &numbers[3 * I + I * J]);
    std::copy(targets.begin(), targets.end(), &numbers[3 * I + I * J + kPairs]);
    return numbers;
  }
};

// Ends the search with a step that gains little.
class Settled : public ceres::IterationCallback {
 public:
  explicit Settled(double least_gain) : least_gain_(least_gain) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& step) override {
    const bool is_last = step.iteration > 0 && step.step_is_successful &&
                         step.cost_change <= least_gain_ * step.cost;
    return is_last ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  double least_gain_;
};

template <int I, int J>
int Run(const std::string& folder, int steps, int threads, int runs, double radius,
        double least_gain) {
  const std::vector<double> displacements = Read(folder + "/obs.bin");
  const std::vector<double> start = Read(folder + "/init.bin");
  std::vector<double> x;
  for (int run = 0; run < runs; ++run) {
    const std::clock_t cpu_begun = std::clock();
    const auto begun = std::chrono::steady_clock::now();
    Scene<I, J> scene(start, steps);
    ceres::Problem::Options of_problem;
    of_problem.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    of_problem.disable_all_safety_checks = true;
    ceres::Problem problem(of_problem);
    scene.Build(displacements.data(), problem);
    ceres::Solver::Options options;
    auto* ordering = new ceres::ParameterBlockOrdering;
    for (int k = 0; k < steps; ++k) ordering->AddElementToGroup(&scene.targets[3 * J * k], 0);
    for (auto& station : scene.stations) ordering->AddElementToGroup(station.data(), 1);
    ordering->AddElementToGroup(scene.distances.data(), 1);
    options.linear_solver_ordering.reset(ordering);
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.num_threads = threads;
    options.initial_trust_region_radius = radius;
    options.max_trust_region_radius = 1e18;
    options.function_tolerance = 1e-10;
    options.gradient_tolerance = 0.0;
    options.parameter_tolerance = 0.0;
    options.max_num_iterations = 100;
    Settled settled(least_gain);
    options.callbacks.push_back(&settled);
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    const std::chrono::duration<double, std::milli> taken =
        std::chrono::steady_clock::now() - begun;
    const double cpu_ms = 1e3 * static_cast<double>(std::clock() - cpu_begun) / CLOCKS_PER_SEC;
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    std::printf(
        "{\"ms\":%.6f,\"cpu_ms\":%.6f,\"cost\":%.17g,\"evaluations\":%d,\"jacobians\":%d,"
        "\"peak_kib\":%ld}\n",
        taken.count(), cpu_ms, summary.final_cost, summary.num_residual_evaluations,
        summary.num_jacobian_evaluations, usage.ru_maxrss);
    x = scene.Solution(start);
  }
  std::ofstream(folder + "/ceres.bin", std::ios::binary)
      .write(reinterpret_cast<const char*>(x.data()), x.size() * sizeof(double));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && argv[1] == std::string("--version")) {
    std::puts(CERES_VERSION_STRING);
    return 0;
  }
  if (argc != 6) return 1;
  const std::string folder = argv[1];
  int stations = 0, targets = 0, steps = 0;
  std::ifstream(folder + "/dims.txt") >> stations >> targets >> steps;
  const int threads = std::atoi(argv[2]), runs = std::atoi(argv[3]);
  const double radius = std::atof(argv[4]), least_gain = std::atof(argv[5]);
  if (stations == 6 && targets == 3) {
    return Run<6, 3>(folder, steps, threads, runs, radius, least_gain);
  }
  if (stations == 8 && targets == 4) {
    return Run<8, 4>(folder, steps, threads, runs, radius, least_gain);
  }
  return 1;
}
