#include "print/labs/full_product.h"

#include "drivers/camera/picture_line.h"
#include "drivers/gas/alicat.h"
#include "drivers/heater/thermostat.h"
#include "drivers/lamp/omnicure.h"
#include "drivers/laser_point/lkg.h"
#include "drivers/laser_profiler/ljv.h"
#include "drivers/robot/fvp.h"
#include "drivers/stage/ensemble.h"
#include "drivers/valve/fvb.h"
#include "print/inputs/mesh_part.h"
#include "print/labs/aerosol_print.h"
#include "print/labs/ice_print.h"
#include "print/labs/inkjet_print.h"
#include "procs/camera/node.h"
#include "procs/controller/node.h"
#include "procs/droplet_estimator/node.h"
#include "procs/droplet_watch/node.h"
#include "procs/flow_estimator/node.h"
#include "procs/gas/node.h"
#include "procs/heater/node.h"
#include "procs/jet/node.h"
#include "procs/lamp/node.h"
#include "procs/laser_point/node.h"
#include "procs/laser_profiler/node.h"
#include "procs/path_planner/node.h"
#include "procs/robot/node.h"
#include "procs/safety/node.h"
#include "procs/scheduler/scheduler.h"
#include "procs/stage/node.h"
#include "procs/surface_mapper/node.h"
#include "procs/valve/node.h"

namespace firn {
namespace {

constexpr const PrintLab* kLabs[] = {
    &kInkjetPrint,
    &kIcePrint,
    &kAerosolPrint,
};

constexpr NamedMaker kNodes[] = {
    {NodeId::kScheduler, &make_scheduler},
    {NodeId::kSurfaceMapper, &make_surface_mapper},
    {NodeId::kController, &make_controller_node},
    {NodeId::kStage, &make_stage, &drivers::ensemble::link_probe},
    {NodeId::kJet, &make_jet},
    {NodeId::kLaserProfiler, &make_laser_profiler, &drivers::ljv::link_probe},
    {NodeId::kLamp, &make_lamp, &drivers::omnicure::link_probe},
    {NodeId::kJetB, &make_jet_b},
    {NodeId::kSafety, &make_safety},
    {NodeId::kDropletEstimator, &make_droplet_estimator},
    {NodeId::kRobot, &make_robot, &drivers::fvp::link_probe},
    {NodeId::kValveA, &make_valve_a, &drivers::fvb::link_probe},
    {NodeId::kValveB, &make_valve_b},
    {NodeId::kLaserPoint, &make_laser_point, &drivers::lkg::link_probe},
    {NodeId::kHeater, &make_heater, &drivers::thermostat::link_probe},
    {NodeId::kPathPlanner, &make_path_planner},
    {NodeId::kFlowEstimator, &make_flow_estimator},
    {NodeId::kCamera, &make_camera, &drivers::picture_line::link_probe},
    {NodeId::kDropletWatch, &make_droplet_watch},
    {NodeId::kGas, &make_gas, &drivers::alicat::link_probe},
};

constexpr Product kFullProduct{kLabs, kNodes, &kMeshInputs};

}  // namespace

const Product& full_product() { return kFullProduct; }

}  // namespace firn
