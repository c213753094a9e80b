/// The fields of structs, each described once. trajectory.h5, checkpoints and JSON use the
/// description. If a field is missing in it, the struct does not compile.
///
///     struct Event {
///       double time = 0;
///       std::string text;
///       static constexpr auto fields() {
///         return describeFields<Event>(field("time", &Event::time, "s"),
///                                      field("what", &Event::text));
///       }
///     };
#pragma once

#include <array>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

namespace kirireel {

/// One field of a struct.
template <typename Owner, typename Value>
struct Field {
  const char* name = "";           ///< in files and JSON, such as "joint_gap"
  Value Owner::*member = nullptr;  ///< pointer to the member
  const char* unit = "";           ///< such as "m"; "1" for a count; empty if it is not a number
  const char* meaning = "";        ///< description for files; may be empty
};

/// A field for describeFields().
template <typename Owner, typename Value>
constexpr Field<Owner, Value> field(const char* name, Value Owner::*member, const char* unit = "",
                                    const char* meaning = "") {
  return {name, member, unit, meaning};
}

/// Converts to any type, in expressions that are never evaluated.
struct Anything {
  /// Not defined.
  template <typename Value>
  operator Value() const;
};

/// Whether a struct can be made from as many values as there are indices.
template <typename Struct, std::size_t... k>
constexpr bool takes(std::index_sequence<k...>) {
  return requires {
    Struct{(static_cast<void>(k), Anything())...};
  };
}

/// The number of fields of a struct without constructors, up to `most`.
template <typename Struct, std::size_t most = 24>
constexpr std::size_t fieldCount() {
  if constexpr (takes<Struct>(std::make_index_sequence<most>())) {
    return most;
  } else {
    return fieldCount<Struct, most - 1>();
  }
}

/// The description of a struct: all of its fields, in order.
template <typename Struct, typename... Values>
constexpr auto describeFields(const Field<Struct, Values>&... fields) {
  static_assert(fieldCount<Struct>() == sizeof...(Values),
                "a field of the struct is not described");
  return std::tuple(fields...);
}

/// A struct that describes its fields.
template <typename Struct>
concept HasFields = requires {
  std::remove_const_t<Struct>::fields();
};

/// Calls visit(field, value) for each field of a struct, in order.
template <HasFields Struct, typename Visit>
constexpr void forEachField(Struct& of, const Visit& visit) {
  std::apply([&](const auto&... each) { (visit(each, of.*each.member), ...); },
             std::remove_const_t<Struct>::fields());
}

/// A struct as a JSON object: its fields by name, in order, and the same for structs within it.
template <typename Json, HasFields Struct>
Json fieldsJson(const Struct& of) {
  Json json = Json::object();
  forEachField(of, [&json](const auto& field, const auto& value) {
    if constexpr (HasFields<std::remove_cvref_t<decltype(value)>>) {
      json[field.name] = fieldsJson<Json>(value);
    } else {
      json[field.name] = value;
    }
  });
  return json;
}

/// The name of a field in files; it must be described.
template <typename Struct, typename Value>
constexpr const char* nameOfField(Value Struct::*member) {
  const char* name = "";
  const auto compare = [&]<typename Other>(const Field<Struct, Other>& one) {
    if constexpr (std::is_same_v<Other, Value>) {
      if (one.member == member) name = one.name;
    }
  };
  std::apply([&](const auto&... each) { (compare(each), ...); }, Struct::fields());
  return name;
}

/// The fields of one type among those described, in order.
template <typename Value, typename Struct, typename... Values>
constexpr auto fieldsOfType(const std::tuple<Field<Struct, Values>...>& described) {
  std::array<Field<Struct, Value>, (std::size_t{std::is_same_v<Values, Value>} + ...)> found;
  std::size_t next = 0;
  const auto keep = [&]<typename Other>(const Field<Struct, Other>& one) {
    if constexpr (std::is_same_v<Other, Value>) found[next++] = one;
  };
  std::apply([&](const auto&... each) { (keep(each), ...); }, described);
  return found;
}

}  // namespace kirireel
