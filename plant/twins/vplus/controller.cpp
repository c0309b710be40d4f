#include "plant/twins/vplus/controller.h"

#include <stdexcept>

namespace firn::plant::vplus {
namespace {

void io_variable(Archive& a, Variable& v) {
  std::vector<Element> keys, text_keys;
  std::vector<float> reals;
  std::vector<std::string> texts;
  if (!a.loading()) {
    for (const auto& [key, real] : v.reals) {
      keys.push_back(key);
      reals.push_back(real);
    }
    for (const auto& [key, text] : v.texts) {
      text_keys.push_back(key);
      texts.push_back(text);
    }
  }
  Value& s = v.scalar;
  a.all(s.type, s.defined, s.real, s.point, s.text, keys, reals, text_keys, texts);
  if (!a.loading()) return;
  if (keys.size() != reals.size() || text_keys.size() != texts.size())
    throw std::runtime_error("world state: an array of V+ is damaged");
  v.reals.clear();
  v.texts.clear();
  for (std::size_t n = 0; n < keys.size(); ++n) v.reals[keys[n]] = reals[n];
  for (std::size_t n = 0; n < text_keys.size(); ++n) v.texts[text_keys[n]] = texts[n];
}

template <class Vector, class Each>
void io_each(Archive& a, Vector& values, std::size_t most, Each each) {
  std::uint64_t count = values.size();
  a.all(count);
  if (count > most) throw std::runtime_error("world state: the machine of V+ is damaged");
  values.resize(count);
  for (auto& v : values) each(v);
}

}  // namespace

Frame Controller::frame_of(std::uint32_t program) const {
  const Program& p = code.programs[program];
  Frame f;
  f.program = program;
  f.locals.resize(p.locals.size());
  f.slots.resize(p.slots);
  return f;
}

void Controller::start(Task& task, std::uint32_t program) const {
  task = Task{};
  task.runs = true;
  task.frames.push_back(frame_of(program));
}

void Frame::io(Archive& a) {
  a.all(program, at, reaction, slots);
  constexpr std::size_t kMost = 4096;
  io_each(a, locals, kMost, [&](Local& l) {
    a.all(l.is_reference, l.to.global, l.to.frame, l.to.variable, l.to.element);
    io_variable(a, l.own);
  });
}

void Task::io(Archive& a) {
  a.all(runs, selected, wait, error, raised, reaction, next_percent, percent, next_duration_s, duration_s,
        stopped_by, frames);
}

void Controller::io(Archive& a) {
  a.all(network, now_us, slice, elements, iostat, monitor_percent, robot_task, statements, last, timers_us,
        written, typed);
  for (Task& task : tasks) task.io(a);
  io_each(a, globals, code.global_types.size(), [&](Variable& v) { io_variable(a, v); });
  if (!a.loading()) return;
  // Statements and variables are found by number: the numbers must be this text's.
  bool sound = globals.size() == code.global_types.size() && robot_task < std::int32_t(kTasks);
  for (const Task& task : tasks) {
    sound =
        sound && task.reaction < std::int32_t(code.programs.size()) && (!task.runs || !task.frames.empty());
    for (const Frame& f : task.frames)
      sound = sound && f.program < code.programs.size() &&
              f.locals.size() == code.programs[f.program].locals.size() &&
              f.slots.size() == code.programs[f.program].slots &&
              f.at < code.programs[f.program].statements.size();
  }
  if (!sound) throw std::runtime_error("world state: its V+ program is another one");
}

}  // namespace firn::plant::vplus
