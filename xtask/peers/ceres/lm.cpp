// Ceres on the tracker problem: lm FOLDER THREADS RUNS INITIAL_RADIUS
//
// As fast as Ceres goes on it: one parameter block per step, analytic derivatives, one residual
// block per step with all of its ranges and distances, DENSE_SCHUR with the steps eliminated.
// Prints a line of JSON per run, with the most memory that the process has had so far; the
// solution goes to ceres.bin beside the problem.
#include <ceres/ceres.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
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

// Parameter blocks: stations 0 to I - 1, dead paths, distances, targets of the step. Of the
// stations that carry the frame only the free coordinates are parameters.
template <int I, int J>
class Step : public ceres::CostFunction {
 public:
  static constexpr int kPairs = J * (J - 1) / 2;
  static constexpr int kRows = I * J + kPairs;

  explicit Step(const double* displacements) : displacements_(displacements) {
    set_num_residuals(kRows);
    for (int i = 1; i < I; ++i) mutable_parameter_block_sizes()->push_back(std::min(i, 3));
    mutable_parameter_block_sizes()->push_back(I * J);
    mutable_parameter_block_sizes()->push_back(kPairs);
    mutable_parameter_block_sizes()->push_back(3 * J);
  }

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const double* dead_paths = x[I - 1];
    const double* distances = x[I];
    const double* targets = x[I + 1];
    if (jacobians != nullptr) Clear(jacobians);
    double cosines[3];
    for (int i = 0; i < I; ++i) {
      double station[3] = {0.0, 0.0, 0.0};
      const int size = std::min(i, 3);
      for (int c = 0; c < size; ++c) station[c] = x[i - 1][c];
      for (int j = 0; j < J; ++j) {
        const int row = j * I + i;
        const double range = Distance(targets + 3 * j, station, cosines);
        residuals[row] = range - displacements_[row] - dead_paths[i * J + j];
        if (jacobians == nullptr) continue;
        for (int c = 0; c < 3; ++c) Set(jacobians, I + 1, row, 3 * J, 3 * j + c, cosines[c]);
        for (int c = 0; c < size; ++c) Set(jacobians, i - 1, row, size, c, -cosines[c]);
        Set(jacobians, I - 1, row, I * J, i * J + j, -1.0);
      }
    }
    int n = 0;
    for (int a = 0; a < J; ++a) {
      for (int b = a + 1; b < J; ++b, ++n) {
        const int row = I * J + n;
        residuals[row] = Distance(targets + 3 * a, targets + 3 * b, cosines) - distances[n];
        if (jacobians == nullptr) continue;
        for (int c = 0; c < 3; ++c) {
          Set(jacobians, I + 1, row, 3 * J, 3 * a + c, cosines[c]);
          Set(jacobians, I + 1, row, 3 * J, 3 * b + c, -cosines[c]);
        }
        Set(jacobians, I, row, kPairs, n, -1.0);
      }
    }
    return true;
  }

 private:
  static void Set(double** jacobians, int block, int row, int width, int column, double value) {
    if (jacobians[block] != nullptr) jacobians[block][row * width + column] = value;
  }

  void Clear(double** jacobians) const {
    for (size_t block = 0; block < parameter_block_sizes().size(); ++block) {
      if (jacobians[block] == nullptr) continue;
      std::fill_n(jacobians[block], kRows * parameter_block_sizes()[block], 0.0);
    }
  }

  const double* displacements_;
};

template <int I, int J>
int Run(const std::string& folder, int steps, int threads, int runs, double radius) {
  const std::vector<double> displacements = Read(folder + "/obs.bin");
  const std::vector<double> start = Read(folder + "/init.bin");
  std::vector<double> x;
  for (int run = 0; run < runs; ++run) {
    x = start;
    double* shared = x.data();
    // Coordinates that fix the frame lie behind the free ones of their station.
    const std::clock_t cpu_begun = std::clock();
    const auto begun = std::chrono::steady_clock::now();
    ceres::Problem problem;
    std::vector<double*> blocks;
    for (int i = 1; i < I; ++i) blocks.push_back(shared + 3 * i);
    blocks.push_back(shared + 3 * I);
    blocks.push_back(shared + 3 * I + I * J);
    blocks.push_back(nullptr);
    auto* ordering = new ceres::ParameterBlockOrdering;
    double* targets = shared + 3 * I + I * J + Step<I, J>::kPairs;
    for (int k = 0; k < steps; ++k) {
      blocks.back() = targets + 3 * J * k;
      problem.AddResidualBlock(new Step<I, J>(&displacements[I * J * k]), nullptr, blocks);
      ordering->AddElementToGroup(blocks.back(), 0);
    }
    for (size_t b = 0; b + 1 < blocks.size(); ++b) ordering->AddElementToGroup(blocks[b], 1);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.linear_solver_ordering.reset(ordering);
    options.num_threads = threads;
    options.initial_trust_region_radius = radius;
    options.max_trust_region_radius = 1e18;
    options.function_tolerance = 1e-10;
    options.gradient_tolerance = 0.0;
    options.parameter_tolerance = 0.0;
    options.max_num_iterations = 100;
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
  }
  std::ofstream(folder + "/ceres.bin", std::ios::binary)
      .write(reinterpret_cast<const char*>(x.data()), x.size() * sizeof(double));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return 1;
  const std::string folder = argv[1];
  int stations = 0, targets = 0, steps = 0;
  std::ifstream(folder + "/dims.txt") >> stations >> targets >> steps;
  const int threads = std::atoi(argv[2]), runs = std::atoi(argv[3]);
  const double radius = std::atof(argv[4]);
  if (stations == 6 && targets == 3) return Run<6, 3>(folder, steps, threads, runs, radius);
  if (stations == 8 && targets == 4) return Run<8, 4>(folder, steps, threads, runs, radius);
  return 1;
}
