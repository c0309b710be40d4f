// firn-demo: the command demo with the ink-jet lab alone, which is built sooner than all of firn.
#include "cli/commands.h"
#include "cli/program.h"
#include "print/labs/inkjet_print.h"
#include "procs/controller/node.h"
#include "procs/droplet_estimator/node.h"
#include "procs/jet/node.h"
#include "procs/lamp/node.h"
#include "procs/laser_profiler/node.h"
#include "procs/safety/node.h"
#include "procs/scheduler/scheduler.h"
#include "procs/stage/node.h"
#include "procs/surface_mapper/node.h"

namespace {

using namespace firn;

constexpr Command kCommands[] = {
    {"demo", "prints a cylinder under each scheme, replays the runs, writes a report", declare_demo},
};
constexpr const PrintLab* kLabs[] = {&kInkjetPrint};
constexpr NamedMaker kNodes[] = {
    {NodeId::kScheduler, &make_scheduler},
    {NodeId::kSurfaceMapper, &make_surface_mapper},
    {NodeId::kController, &make_controller_node},
    {NodeId::kStage, &make_stage},
    {NodeId::kJet, &make_jet},
    {NodeId::kLaserProfiler, &make_laser_profiler},
    {NodeId::kLamp, &make_lamp},
    {NodeId::kJetB, &make_jet_b},
    {NodeId::kSafety, &make_safety},
    {NodeId::kDropletEstimator, &make_droplet_estimator},
};
constexpr Product kProduct{kLabs, kNodes};

}  // namespace

int main(int argc, char** argv) { return run_program(kCommands, kProduct, argc, argv); }
