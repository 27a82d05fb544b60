#include "taut/scene/load_context.h"

namespace taut {

namespace {

/// plane = "xy": x is displaced by y.
void readPlane(TableReader &table, DeformerKeys &keys) {
    const TomlValue *value = table.find("plane");
    keys.axis = 0;
    keys.axis2 = 1;
    if (value == nullptr) return;
    const int plane = toChoice<int>(*value, {{"xy", 1}, {"xz", 2}, {"yx", 3}, {"yz", 5}, {"zx", 6}, {"zy", 7}});
    keys.axis = plane / 3;
    keys.axis2 = plane % 3;
}

void readRange(TableReader &table, DeformerKeys &keys) {
    const TomlValue *value = table.find("range");
    if (value == nullptr) return;
    const auto &pair = toArray(*value, 2, "a pair [lower, upper]");
    keys.lower = toNumber(pair[0], kAnyNumber);
    keys.upper = toNumber(pair[1], kAnyNumber);
    failOn(value->where, mistakeInRange(keys));
}

int toPointIndex(const TomlValue &value, int count) {
    return static_cast<int>(toInteger(value, {0, count - 1}));
}

/// [i, j, k, dx, dy, dz] or { at = [i, j, k], offset = [dx, dy, dz] or keyframes }.
void readOffset(const TomlValue &entry, DeformerKeys &keys) {
    std::array<int, 3> at{};
    Keyed<DVec3> offset;
    const TomlValue *indices = &entry;
    if (entry.kind == TomlValue::Kind::Table) {
        TableReader table(entry, "of a lattice offset", {"at", "offset"});
        indices = &table.required("at", "at = [i, j, k]");
        toArray(*indices, 3, "three indices");
        offset = toKeyedVec3(table.required("offset", "offset = [dx, dy, dz]"), kAnyNumber);
    } else {
        const auto &items = toArray(entry, 6, "[i, j, k, dx, dy, dz] or { at, offset }");
        offset = Keyed<DVec3>(DVec3(toNumber(items[3], kAnyNumber), toNumber(items[4], kAnyNumber), toNumber(items[5], kAnyNumber)));
    }
    for (std::size_t i = 0; i < 3; ++i) at[i] = toPointIndex(indices->items[i], keys.latticePoints[i]);
    const int index = at[0] + keys.latticePoints[0] * (at[1] + keys.latticePoints[1] * at[2]);
    keys.latticeOffsets[static_cast<std::size_t>(index)] = offset;
}

constexpr double kPointBytes = 160; ///< of a control point: its keys and its place

void readLattice(Budget &budget, TableReader &table, DeformerKeys &keys) {
    table.read("lower", keys.latticeLower, vec3In());
    table.read("upper", keys.latticeUpper, vec3In());
    failOn(table.where(), mistakeInLatticeBox(keys));
    if (const TomlValue *points = table.find("points")) {
        const auto &counts = toArray(*points, 3, "three integers in [2, 16]");
        for (std::size_t i = 0; i < 3; ++i) keys.latticePoints[i] = static_cast<int>(toInteger(counts[i], kLatticePoints));
    }
    const auto &n = keys.latticePoints;
    budget.take(static_cast<double>(n[0]) * n[1] * n[2] * kPointBytes, table.where().text(), "a lattice");
    keys.latticeOffsets.assign(static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1]) * static_cast<std::size_t>(n[2]),
                               Keyed<DVec3>(DVec3(0)));
    const TomlValue *offsets = table.find("offsets");
    if (offsets == nullptr) return;
    if (offsets->kind != TomlValue::Kind::Array) failInput(offsets->where, describe(*offsets), "an array of offsets");
    for (const TomlValue &entry : offsets->items) readOffset(entry, keys);
}

void readWave(TableReader &table, DeformerKeys &keys) {
    table.read("axis", keys.axis, toAxis);
    table.read("direction", keys.axis2, toAxis);
    table.read("amplitude", keys.amplitude, keyedNumberIn(kAnyNumber));
    table.read("wavelength", keys.wavelength, keyedNumberIn(kPositive));
    table.read("phase_deg", keys.phase, keyedNumberIn(kDegrees, radians(1)));
}

DeformerKeys loadDeformer(Budget &budget, const TomlValue &entry) {
    TableReader table(entry, "[[mesh.deform]]",
                      {"type", "centre", "factor", "plane", "amount", "axis", "towards", "direction", "range", "angle_deg", "amplitude",
                       "wavelength", "phase_deg", "lower", "upper", "points", "offsets"});
    DeformerKeys keys;
    table.read("type", keys.type,
               oneOf<DeformerType>({{"stretch", DeformerType::Stretch},
                                    {"shear", DeformerType::Shear},
                                    {"bend", DeformerType::Bend},
                                    {"twist", DeformerType::Twist},
                                    {"taper", DeformerType::Taper},
                                    {"lattice", DeformerType::Lattice},
                                    {"wave", DeformerType::Wave}}));
    if (keys.type != DeformerType::Lattice) table.read("centre", keys.centre, vec3In());
    switch (keys.type) {
    case DeformerType::Stretch: table.read("factor", keys.factor, keyedTripleIn(kPositive)); break;
    case DeformerType::Shear:
        readPlane(table, keys);
        table.read("amount", keys.amount, keyedNumberIn(kAnyNumber));
        break;
    case DeformerType::Bend:
        table.read("axis", keys.axis, toAxis);
        table.read("towards", keys.axis2, toAxis);
        table.read("angle_deg", keys.amount, keyedNumberIn(kDegrees, radians(1)));
        readRange(table, keys);
        failOn(table.where(), mistakeInBend(keys));
        break;
    case DeformerType::Twist:
        table.read("axis", keys.axis, toAxis);
        table.read("angle_deg", keys.amount, keyedNumberIn(kDegrees, radians(1)));
        readRange(table, keys);
        break;
    case DeformerType::Taper:
        table.read("axis", keys.axis, toAxis);
        table.read("amount", keys.amount, keyedNumberIn(kTaper));
        readRange(table, keys);
        break;
    case DeformerType::Lattice: readLattice(budget, table, keys); break;
    case DeformerType::Wave: readWave(table, keys); break;
    }
    table.finish();
    return keys;
}

} // namespace

std::vector<DeformerKeys> loadDeformers(Budget &budget, const TomlValue &section) {
    if (section.kind != TomlValue::Kind::Array) failInput(section.where, describe(section), "tables [[mesh.deform]]");
    std::vector<DeformerKeys> deformers;
    for (const TomlValue &entry : section.items) deformers.push_back(loadDeformer(budget, entry));
    return deformers;
}

} // namespace taut
