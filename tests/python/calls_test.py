# SPDX-License-Identifier: BSD-3-Clause
"""Compares the descriptions of casd and hilsim with docs/develop/protocol.md and with their calls and answers."""

import contextlib
import re
import time
import unittest

from helpers import PATIENCE_S, SOURCE, FolderTest

import cas

SAMPLES = {"altitude_m": 2.5, "north_m": 1, "east_m": 1, "down_m": -3, "mode": "HOLD", "message": "ATTITUDE", "command": 512,
           "loop": "position", "name": "MPC_XY_P", "value": 1.0, "link": "fcu", "system": 1, "component": 1, "time_s": 0.1,
           "p": 1.0, "entry": {"endpoint": "udp:127.0.0.1:9"}}
WRONG = {"string": 5, "number": "x", "integer": "x", "boolean": "x", "array": "x", "object": "x"}


def described(document):
    """{method: {param: entry}} of all entries with a group."""
    return {method["name"]: {each["name"]: each for each in method["params"]}
            for method in document["methods"] if "." in method["name"] and not method["name"].startswith("rpc.")}


def heads(page):
    """{method: {"altitude_m", "vehicle?"}} of lines such as **vehicle.land**, **vehicle.hold** {vehicle?}."""
    found, pending = {}, []
    for name, params in re.findall(r"\*\*([a-z_]+\.[a-z_]+)\*\*|\{([a-z_?, \n]*)\}", page):
        if name:
            pending.append(name)
        elif pending:
            keys = {key.strip() for key in params.split(",") if key.strip()}
            found.update({each: keys for each in pending})
            pending = []
    return found


class Validator:
    """The part of JSON Schema that descriptions use."""

    def __init__(self, document):
        self.shapes = document.get("components", {}).get("schemas", {})

    def faults(self, schema, value, path):
        """Sentences on where `value` is something else."""
        if "$ref" in schema:
            return self.faults(self.shapes[schema["$ref"].rpartition("/")[2]], value, path)
        if "anyOf" in schema:
            all_faults = [self.faults(each, value, path) for each in schema["anyOf"]]
            return [] if any(not faults for faults in all_faults) else all_faults[0]
        kind = schema.get("type")
        fits = {None: True, "object": isinstance(value, dict), "array": isinstance(value, list),
                "string": isinstance(value, str), "boolean": isinstance(value, bool), "null": value is None,
                "integer": isinstance(value, int) and not isinstance(value, bool),
                "number": isinstance(value, (int, float)) and not isinstance(value, bool)}[kind]
        if not fits:
            return [f"{path} is no {kind}: {value!r}"]
        if kind == "array":
            return [fault for i, each in enumerate(value) for fault in self.faults(schema["items"], each, f"{path}[{i}]")]
        if kind != "object":
            return []
        own, rest = schema.get("properties", {}), schema["additionalProperties"]
        faults = [f"{path}/{key} is missing" for key in schema.get("required", []) if key not in value]
        for key, each in value.items():
            if key in own:
                faults += self.faults(own[key], each, f"{path}/{key}")
            elif rest is False:
                faults.append(f"{path}/{key} is not described")
            else:
                faults += self.faults(rest, each, f"{path}/{key}")
        return faults


class DescriptionTest(FolderTest):
    @classmethod
    def setUpClass(cls):
        cls.stack = contextlib.ExitStack()
        cls.addClassCleanup(cls.stack.close)
        import tempfile
        folder = cls.stack.enter_context(tempfile.TemporaryDirectory())
        cls.bench = cls.stack.enter_context(cas.Bench(folder=folder))
        cls.casd = cls.bench.casd
        cls.document = cls.casd.describe()

    def test_the_page_has_the_methods_and_parameters_that_casd_describes(self):
        page = heads((SOURCE / "docs/develop/protocol.md").read_text(encoding="utf-8"))
        own = {name: {key + ("" if each["required"] else "?") for key, each in params.items()}
               for name, params in described(self.document).items()}
        self.assertEqual({name: page.get(name) for name in own}, own)

    def test_every_parameter_is_taken_and_no_other_one(self):
        for name, params in described(self.document).items():
            needed = {key: SAMPLES[key] for key, each in params.items() if each["required"]}
            if name == "gain.set":
                needed["p"] = 1.0
            with self.assertRaises(cas.WrongCall, msg=name) as caught:
                self.casd.call(name, {**needed, "zzz": 1})
            self.assertIn("zzz", str(caught.exception))
            for key, each in params.items():
                schema = each["schema"]
                wrong = {} if "anyOf" in schema else WRONG[schema["type"]]
                with self.assertRaises(cas.WrongCall, msg=f"{name} {key}") as caught:
                    self.casd.call(name, {**needed, key: wrong})
                self.assertIn(f'"{key}"', str(caught.exception), name)
                if each["required"]:
                    with self.assertRaises(cas.WrongCall, msg=f"{name} without {key}"):
                        self.casd.call(name, {other: value for other, value in needed.items() if other != key})

    def test_answers_and_notifications_are_as_described(self):
        bench, casd = self.bench, self.casd
        validator = Validator(self.document)
        results = {each["name"]: each["result"]["schema"] for each in self.document["methods"]}
        asked = set()

        def ask(name, /, **params):
            asked.add(name)
            answer = casd.call(name, params, 130)
            self.assertEqual(validator.faults(results[name], answer, name), [])
            return answer

        topics = {name: casd.subscribe(name) for name in self.document["x-topics"]}
        bench.arm()
        bench.run_for(2.0)
        bench._tell_home()
        for name in ("vehicle.land", "vehicle.hold", "vehicle.rtl", "vehicle.arm", "vehicle.takeoff", "vehicle.goto",
                     "vehicle.mode", "vehicle.manual_control", "vehicle.message_interval", "vehicle.command"):
            params = described(self.document)[name]
            needed = {key: SAMPLES[key] for key, each in params.items() if each["required"]}
            with contextlib.suppress(cas.Refused):  # not in this state; the others must be enough
                ask(name, **({"mode": "POSCTL"} if name == "vehicle.mode" else needed))
        bench.run_for(1.0)
        ask("message.value", link="fcu", message="ATTITUDE", system=1, component=1)
        ask("message.value", link="fcu", message="DEBUG", system=1, component=1)
        bench.run_for(0.5)
        ask("message.value", link="fcu", message="ATTITUDE", system=1, component=1)
        ask("log.start", file="look")
        ask("link.remove", link=ask("link.add", entry=SAMPLES["entry"])["link"])
        ask("gain.set", loop="position", p=1.0)
        ask("gain.get", loop="position")
        ask("param.get", name="MPC_XY_P")
        ask("param.set", name="MPC_XY_P", value=1.1)
        for name, params in described(self.document).items():
            if name not in asked and not any(each["required"] for each in params.values()):
                if name not in ("vehicle.reboot", "vehicle.disarm", "param.list"):
                    ask(name)
        stop = time.monotonic() + 2 * PATIENCE_S
        heard = set()
        while not {"messages", "statustext"} <= heard and time.monotonic() < stop:
            bench.run_for(1.0)
            for name, subscription in topics.items():
                with contextlib.suppress(cas.CallTimeout):
                    notice = subscription.next(0.05)
                    heard.add(name)
                    self.assertEqual(validator.faults(self.document["x-topics"][name]["params"], notice, name), [])
        self.assertLessEqual({"messages", "statustext"}, heard)
        ask("vehicle.disarm", force=True)
        unasked = set(described(self.document)) - asked
        self.assertLessEqual(unasked, {"vehicle.reboot", "param.list", "vehicle.hold", "vehicle.rtl"})

    def test_hilsim_answers_as_it_describes(self):
        sim = self.bench.sim
        document = sim.describe()
        validator = Validator(document)
        for method in document["methods"]:
            if not method["name"].startswith("sim.") or method["name"] in ("sim.quit", "sim.reset", "sim.resume"):
                continue
            if method["name"] == "sim.mesh":  # this vehicle's scene has none
                for params, words in (({}, '"hash" is missing'), ({"hash": "none"}, "no such mesh")):
                    with self.assertRaisesRegex(cas.WrongCall, words):
                        sim.client.call("sim.mesh", params)
                continue
            if method["name"] == "sim.fault":  # this vehicle takes no orders
                for params, words in (({}, '"vehicle" is missing'),
                                      ({"vehicle": "none", "fault": {}}, "none")):
                    with self.assertRaisesRegex(cas.CallError, words):
                        sim.client.call("sim.fault", params)
                continue
            if not method["params"]:
                with self.assertRaisesRegex(cas.WrongCall, "is no parameter of this method"):
                    sim.client.call(method["name"], {"other": 1})
            params = {"sim.run_until": {"time_s": 0.0}, "sim.phase": {"name": "look"}}.get(method["name"], {})
            answer = sim.client.call(method["name"], params)
            self.assertEqual(validator.faults(method["result"]["schema"], answer, method["name"]), [])


if __name__ == "__main__":
    unittest.main()
