// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

/// The part of JSON Schema that docs/report.schema.json uses.
namespace nacre::app::test {

class SchemaChecker {
 public:
  explicit SchemaChecker(nlohmann::json schema) : root_(std::move(schema)) {}

  /// What `value` breaks, each with its place; empty: it is valid.
  [[nodiscard]] std::vector<std::string> problems(const nlohmann::json& value) const {
    return problems(value, root_, "");
  }
  /// The same against #/$defs/NAME.
  [[nodiscard]] std::vector<std::string> problems(const nlohmann::json& value,
                                                  const std::string& definition) const {
    return problems(value, root_["$defs"].at(definition), "");
  }
  /// Places of members that the schema has no word on.
  [[nodiscard]] std::vector<std::string> undescribed(const nlohmann::json& value) const {
    Problems found;
    find_undescribed(value, {root_}, "", found);
    return found;
  }

 private:
  using Json = nlohmann::json;
  using Problems = std::vector<std::string>;

  static bool is_of_type(const Json& value, const std::string& type) {
    if (type == "object") return value.is_object();
    if (type == "array") return value.is_array();
    if (type == "string") return value.is_string();
    if (type == "boolean") return value.is_boolean();
    if (type == "null") return value.is_null();
    if (type == "integer") return value.is_number_integer();
    return type == "number" && value.is_number();
  }

  static void add(Problems& all, const Problems& more) {
    all.insert(all.end(), more.begin(), more.end());
  }

  static void check_type(const Json& value, const Json& schema, const std::string& at,
                         Problems& found) {
    if (!schema.contains("type")) return;
    const Json& types = schema["type"];
    bool fits = false;
    for (const Json& type : types.is_array() ? types : Json::array({types}))
      fits = fits || is_of_type(value, type);
    if (!fits) found.push_back(at + ": is not of type " + types.dump());
  }

  void check_object(const Json& value, const Json& schema, const std::string& at,
                    Problems& found) const {
    for (const Json& key : schema.value("required", Json::array()))
      if (!value.contains(key)) found.push_back(at + ": lacks " + key.dump());
    const Json properties = schema.value("properties", Json::object());
    for (const auto& [key, member] : value.items()) {
      if (properties.contains(key)) {
        add(found, problems(member, properties[key], at + "/" + key));
      } else if (schema.contains("additionalProperties")) {
        add(found, problems(member, schema["additionalProperties"], at + "/" + key));
      }
    }
  }

  void check_array(const Json& value, const Json& schema, const std::string& at,
                   Problems& found) const {
    if (value.size() < schema.value("minItems", std::size_t{0}) ||
        value.size() > schema.value("maxItems", std::size_t(-1)))
      found.push_back(at + ": has " + std::to_string(value.size()) + " items");
    if (!schema.contains("items")) return;
    for (std::size_t i = 0; i < value.size(); ++i)
      add(found, problems(value[i], schema["items"], at + "/" + std::to_string(i)));
  }

  [[nodiscard]] Problems problems(const Json& value, const Json& schema,
                                  const std::string& at) const {
    Problems found;
    if (schema.contains("$ref")) {
      const std::string target = schema["$ref"];
      add(found, problems(value, root_.at(Json::json_pointer(target.substr(1))), at));
    }
    check_type(value, schema, at, found);
    if (schema.contains("const") && value != schema["const"])
      found.push_back(at + ": is not " + schema["const"].dump());
    if (schema.contains("enum")) {
      bool known = false;
      for (const Json& allowed : schema["enum"]) known = known || value == allowed;
      if (!known) found.push_back(at + ": is none of " + schema["enum"].dump());
    }
    if (schema.contains("minimum") && value.is_number() && value < schema["minimum"])
      found.push_back(at + ": is too small");
    if (value.is_object()) check_object(value, schema, at, found);
    if (value.is_array()) check_array(value, schema, at, found);
    if (schema.contains("anyOf")) {
      Problems of_all;
      for (const Json& choice : schema["anyOf"]) {
        const Problems of_one = problems(value, choice, at);
        if (of_one.empty()) return found;
        add(of_all, of_one);
      }
      found.push_back(at + ": fits none of the choices");
      add(found, of_all);
    }
    return found;
  }

  /// The schema and those that it refers to and chooses from.
  [[nodiscard]] std::vector<Json> branches(const Json& schema) const {
    std::vector<Json> all = {schema};
    const auto add_all = [&](const Json& more) {
      for (Json& branch : branches(more)) all.push_back(std::move(branch));
    };
    if (schema.contains("$ref"))
      add_all(root_.at(Json::json_pointer(schema["$ref"].get<std::string>().substr(1))));
    for (const Json& choice : schema.value("anyOf", Json::array())) add_all(choice);
    return all;
  }

  void find_undescribed(const Json& value, const std::vector<Json>& schemas, const std::string& at,
                        Problems& found) const {
    std::vector<Json> all;
    for (const Json& schema : schemas)
      for (Json& branch : branches(schema)) all.push_back(std::move(branch));
    for (const auto& [key, member] : value.items()) {
      if (!member.is_structured() && !value.is_object()) continue;
      std::vector<Json> of_member;
      for (const Json& schema : all) {
        if (value.is_array()) {
          if (schema.contains("items")) of_member.push_back(schema["items"]);
        } else if (schema.contains("properties") && schema["properties"].contains(key)) {
          of_member.push_back(schema["properties"][key]);
        } else if (schema.contains("additionalProperties")) {
          of_member.push_back(schema["additionalProperties"]);
        }
      }
      const std::string place = at + "/" + key;
      if (of_member.empty()) found.push_back(place);
      if (!of_member.empty() && member.is_structured())
        find_undescribed(member, of_member, place, found);
    }
  }

  Json root_;
};

}  // namespace nacre::app::test
