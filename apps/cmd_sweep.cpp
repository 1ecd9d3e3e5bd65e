// aluminate sweep SCENE.. --vary KEY=V|V.. -o DIR [--shard I/N]: many frames as independent jobs, one table.
// Exit 0 all results are there, 1 jobs of other shards are missing, 2 a job failed.
#include <fmt/format.h>

#include <memory>

#include "apps/session.hpp"
#include "shading/report/sweep.hpp"

namespace aluminate::apps {
namespace {

struct Arguments {
  FrameArguments frame;
  report::SweepRequest request;
  std::vector<std::string> vary;
  std::string shard;
};

void run(Arguments& a, Session& session) {
  a.request.options = a.frame.resolve();
  for (const std::string& text : a.vary) report::add_variation(a.request, text);
  if (!a.shard.empty()) report::parse_shard(a.request, a.shard);
  const report::SweepDone done = report::run_sweep(a.request);
  fmt::print("{}", report::sweep_text(done, a.request.folder));
  session.exit_code = !done.failed.empty() ? kUsageError : done.missing > 0 ? kAnswerIsNo : kDone;
}

}  // namespace

void add_sweep(CLI::App& app, Session& session) {
  auto a = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("sweep", "price a matrix of scenes and options; jobs can be spread over machines");
  command->footer(
      "Examples:\n  aluminate sweep a.glb b.glb --vary 'visibility=cheap|schlick-smith' --vary "
      "'platform=xenos|rsx' -o out\n"
      "  mpirun -n 8 aluminate sweep a.glb --vary 'lights=rig:1|rig:4|rig:16' -o out --threads 1\n"
      "Processes that share the folder pull jobs from it. Without a shared folder, deal them out and collect "
      "out/jobs:\n"
      "  aluminate sweep a.glb --vary ... -o out --shard $SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT");
  command->add_option("SCENE", a->request.scenes, ".gltf or .glb files")->required();
  command->add_option("--vary", a->vary, "an option and its values; the last one given varies fastest")
      ->type_name("KEY=V|V..")
      ->allow_extra_args(false);
  command
      ->add_option("-o,--output", a->request.folder,
                   "folder of results and tables; what is there already is kept")
      ->required();
  command->add_option("--shard", a->shard, "run every N-th job, beginning with the I-th")->type_name("I/N");
  a->frame.add_to(*command);
  command->callback([a, &session] { run(*a, session); });
}

}  // namespace aluminate::apps
