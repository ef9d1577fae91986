// The options of every command that has an executor.
#pragma once

#include <CLI/CLI.hpp>

#include "omniflight_jobs/executor.hpp"

namespace omniflight::jobs {

inline void add_executor(CLI::App& app, ExecutorOptions& o) {
  app.add_option(
         "--executor", o.name,
         "local: on this machine; slurm: as a job array on the cluster whose login node this is, with "
         "--out on a file system that all nodes share")
      ->check(CLI::IsMember({"local", "slurm"}));
  const auto slurm = [&](const char* name, auto& value, const char* does) {
    return app.add_option(name, value, std::string("With --executor slurm: ") + does);
  };
  slurm("--partition", o.partition, "partition; default: the cluster's");
  slurm("--account", o.account, "account; default: yours");
  slurm("--time", o.time_min, "longest time of a task [min]; default: the partition's")
      ->check(CLI::Range(0.1, 100000.0));
  slurm("--cpus", o.cpus, "processors of a task")->check(CLI::Range(1, 1024));
  slurm("--tasks-at-once", o.tasks_at_once, "tasks at once; default: as many as the cluster gives")
      ->check(CLI::Range(1, 100000));
  slurm("--jobs-per-task", o.jobs_per_task,
        "jobs that a task does one after another; default: as few as the cluster's largest array allows")
      ->check(CLI::Range(1, 100000));
  slurm("--attempts", o.attempts, "how often jobs that left no result are submitted in all")
      ->check(CLI::Range(1, 100));
  slurm("--wait-h", o.wait_h, "time after which the work is given up; what is there stays [h]")
      ->check(CLI::Range(0.001, 10000.0));
}

}  // namespace omniflight::jobs
