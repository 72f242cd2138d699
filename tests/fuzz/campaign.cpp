#include "tests/fuzz/campaign.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <thread>

#include "tests/fuzz/files.h"

namespace skybody::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kEndless = std::numeric_limits<std::uint64_t>::max();
constexpr std::uint64_t kBlock = 1000;  // inputs per process when inputs are counted
constexpr std::uint64_t kFirstBlock =
    100;  // first block when time is limited: measures the area's speed
constexpr double kBlockSeconds = 2.0;  // duration of the blocks after it
constexpr std::uint64_t kMostBlock = 20000;
constexpr std::uint64_t kMostTold = 40;            // findings per area that are printed and saved
constexpr std::chrono::milliseconds kPatience{5};  // between two polls of the workers

/// For terminals: a message may contain any bytes of the input.
std::string without_controls(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  return text;
}

bool is_chosen(const Options& options, const char* area) {
  return options.areas.empty() ||
         std::find(options.areas.begin(), options.areas.end(), area) != options.areas.end();
}

}  // namespace

Campaign::Campaign(const Options& options, fs::path folder)
    : options_(options), folder_(std::move(folder)) {
  for (const AreaRow& row : area_rows()) {
    if (!is_chosen(options, row.name)) continue;
    const fs::path own = folder_ / row.name;
    fs::create_directories(own);
    Front& front = fronts_.emplace_back();
    front.row = &row;
    front.area = row.make({own, options.policy});
    front.tally.area = row.name;
    add_queues(front);
  }
  deadline_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                 std::chrono::duration<double, std::ratio<60>>(options.minutes));
}

void Campaign::add_queues(Front& front) const {
  const std::string name = front.row->name;
  if (!options_.input.empty()) {
    const std::vector<fs::path> files = {options_.input};
    front.queues.push_back({std::make_unique<FileInputs>(name, files), 0, 1, false});
    return;
  }
  if (options_.corpus) {
    auto seeds = std::make_unique<SeedInputs>(name, front.area->material());
    auto files = std::make_unique<FileInputs>(name, corpus_files(name));
    const std::uint64_t seed_count = seeds->count(), file_count = files->count();
    front.queues.push_back({std::move(seeds), 0, seed_count, true});
    front.queues.push_back({std::move(files), 0, file_count, false});
  }
  const std::uint64_t end = options_.shares_time() ? kEndless : options_.first + options_.count;
  front.queues.push_back({std::make_unique<MadeInputs>(*front.row, *front.area, options_.seed),
                          options_.first, end, false});
}

/// Inputs that have been run, of all areas.
std::uint64_t Campaign::inputs() const {
  std::uint64_t sum = 0;
  for (const Front& front : fronts_) sum += front.tally.inputs();
  return sum;
}

bool Campaign::is_over() const {
  return options_.shares_time() && Clock::now() >= deadline_ && inputs() >= options_.inputs;
}

Campaign::Queue* Campaign::queue_of(Front& front) {
  for (Queue& queue : front.queues) {
    if (queue.next < queue.end) return &queue;
  }
  return nullptr;
}

/// The area that has had the least time.
Campaign::Front* Campaign::next_front() {
  Front* best = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (Front& front : fronts_) {
    const double time = front.tally.seconds + kBlockSeconds * front.workers;
    if (queue_of(front) == nullptr || time >= least) continue;
    least = time;
    best = &front;
  }
  return best;
}

std::uint64_t Campaign::block_size(const Front& front) const {
  if (!options_.shares_time()) return kBlock;
  if (front.tally.seconds < 0.1) return kFirstBlock;
  const double rate = static_cast<double>(front.tally.inputs()) / front.tally.seconds;
  return std::clamp(static_cast<std::uint64_t>(rate * kBlockSeconds), kFirstBlock, kMostBlock);
}

bool Campaign::start(Job& job) {
  Front* front = is_over() ? nullptr : next_front();
  if (front == nullptr) return false;
  Queue& queue = *queue_of(*front);
  const std::uint64_t first = queue.next;
  queue.next += std::min(queue.end - queue.next, block_size(*front));
  job.front = front;
  job.queue = &queue;
  job.end = queue.next;
  ++front->workers;
  run_from(job, first);
  return true;
}

void Campaign::run_from(Job& job, std::uint64_t first) {
  job.worker.start({job.front->area.get(), job.queue->inputs.get(), first, job.end - first,
                    job.queue->only_accepted});
}

/// Adds a block's results; after a finding the rest of the block continues in another process.
void Campaign::take(Job& job, const BlockEnd& end) {
  Tally& tally = job.front->tally;
  tally.refused += end.refused;
  tally.accepted += end.accepted;
  tally.seconds += end.seconds;
  tally.slowest = std::max(tally.slowest, 1e-9 * static_cast<double>(end.slowest_ns));
  if (end.found) {
    ++tally.findings[static_cast<std::size_t>(end.found->kind)];
    tell(*job.front, *job.queue->inputs, *end.found);
    if (end.next < job.end && !is_over()) return run_from(job, end.next);
  }
  --job.front->workers;
}

void Campaign::tell(Front& front, const Inputs& inputs, const Found& found) const {
  if (++front.told > kMostTold) return;
  const char* kind = kFindingNames[static_cast<std::size_t>(found.kind)];
  std::fprintf(stderr, "%s: %s: %s\n", inputs.name(found.input).c_str(), kind,
               without_controls(found.text).c_str());
  std::fprintf(stderr, "  again: skybody_fuzz %s\n", inputs.rerun(found.input).c_str());
  if (front.told == kMostTold) std::fprintf(stderr, "  further ones are only counted\n");
  if (options_.save.empty()) return;
  fs::create_directories(options_.save);
  write_bytes(options_.save / inputs.name(found.input), inputs.make(found.input));
}

std::vector<Tally> Campaign::run() {
  std::vector<Job> jobs;
  for (int k = 0; k < options_.jobs; ++k) {
    const fs::path own = folder_ / ("worker_" + std::to_string(k));
    jobs.push_back({Worker(own, options_.limits, options_.count != 1 && options_.input.empty())});
  }
  for (bool busy = true; busy;) {
    busy = false;
    for (Job& job : jobs) {
      if (job.worker.busy()) {
        if (is_over()) job.worker.stop();
        if (const auto end = job.worker.poll()) take(job, *end);
      }
      busy |= job.worker.busy() || start(job);
    }
    std::this_thread::sleep_for(kPatience);
  }
  std::vector<Tally> tallies;
  for (const Front& front : fronts_) tallies.push_back(front.tally);
  return tallies;
}

void Campaign::run_here() {
  for (Front& front : fronts_) {
    const fs::path own = folder_ / "here";
    fs::remove_all(own);
    fs::create_directories(own);
    front.area->begin(own);
    for (const Queue& queue : front.queues) {
      for (std::uint64_t k = queue.next; k < queue.end; ++k) {
        const Answer answer = front.area->run(queue.inputs->make(k), true);
        std::printf("%s: %s\n", queue.inputs->name(k).c_str(),
                    answer == Answer::kAccepted ? "accepted" : "refused");
      }
    }
  }
}

}  // namespace skybody::fuzz
