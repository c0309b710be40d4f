#include "drivers/jet/jet_kinds.h"

#include <array>

#include "drivers/jet/jet.h"
#include "drivers/jet/microdrop.h"

namespace firn::drivers {
namespace {

constexpr std::array kKinds{&kJetDriveTraits, &kMicrodropTraits};  // in the order of JetKind
static_assert(kKinds.size() == kJetKindWords.size());

}  // namespace

const JetTraits& traits_of(JetKind kind) { return *kKinds[std::size_t(kind)]; }

std::unique_ptr<JetDriver> make_jet(const JetOptions& config) { return traits_of(config.kind).make(config); }

}  // namespace firn::drivers
