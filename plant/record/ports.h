// Port holds the numbers of the simulated instruments' ports, as written in the world's record. Recorded runs
// keep their numbers: a new port must be added at the end.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace firn::plant {

enum class Port : std::uint8_t {
  kStage = 0,
  kJet = 1,
  kProfiler = 2,
  kLamp = 3,
  kJetB = 4,
  kRobot = 5,
  kValveA = 6,
  kValveB = 7,
  kLaserPoint = 8,
  kHeater = 9,
  kCamera = 10,
  kGas = 11,
};

/// Names of the ports, as in the nodes' port tables.
inline constexpr std::string_view kStagePort = "stage";
inline constexpr std::string_view kJetPort = "jet";
inline constexpr std::string_view kProfilerPort = "laser_profiler";
inline constexpr std::string_view kLampPort = "lamp";
inline constexpr std::string_view kJetBPort = "jet_b";
inline constexpr std::string_view kRobotPort = "robot";
inline constexpr std::string_view kValveAPort = "valve_a";
inline constexpr std::string_view kValveBPort = "valve_b";
inline constexpr std::string_view kLaserPointPort = "laser_point";
inline constexpr std::string_view kHeaterPort = "heater";
inline constexpr std::string_view kCameraPort = "camera";
inline constexpr std::string_view kGasPort = "gas";

/// The ports of the ink-jet lab.
inline constexpr std::array kPortNames{kStagePort, kJetPort,  kProfilerPort,
                                       kLampPort,  kJetBPort, kCameraPort};
/// The ports of the ice lab.
inline constexpr std::array kIcePortNames{kRobotPort, kValveAPort, kValveBPort, kLaserPointPort, kHeaterPort};

struct PortRow {
  Port port;
  std::string_view name;
};
inline constexpr PortRow kPorts[] = {
    {Port::kStage, kStagePort},   {Port::kJet, kJetPort},       {Port::kProfiler, kProfilerPort},
    {Port::kLamp, kLampPort},     {Port::kJetB, kJetBPort},     {Port::kRobot, kRobotPort},
    {Port::kValveA, kValveAPort}, {Port::kValveB, kValveBPort}, {Port::kLaserPoint, kLaserPointPort},
    {Port::kHeater, kHeaterPort}, {Port::kCamera, kCameraPort}, {Port::kGas, kGasPort},
};

}  // namespace firn::plant
