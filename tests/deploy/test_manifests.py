"""The Kubernetes manifests: against the published schemas, against each other, and against what they start."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from motionsplice.cli import app
from motionsplice.service.metrics import Metrics
from motionsplice.service.settings import Settings, variable

DEPLOY = Path(__file__).parents[2] / "deploy"
SNIPPET = re.compile(r"```yaml\n(.*?)```", re.DOTALL)
yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")
kubernetes_validate = pytest.importorskip("kubernetes_validate", reason="kubernetes-validate is not installed")

OLDEST, NEWEST = "1.30.0", "1.37.0"


def documents() -> list[dict[str, Any]]:
    return [one for file in sorted(DEPLOY.rglob("*.yaml")) for one in yaml.safe_load_all(file.read_text())]


def of_kind(*kinds: str) -> list[dict[str, Any]]:
    return [one for one in documents() if one["kind"] in kinds]


def pods() -> list[dict[str, Any]]:
    return [one["spec"]["template"] for one in of_kind("Deployment", "Job")]


def containers() -> list[dict[str, Any]]:
    return [one for pod in pods() for one in (*pod["spec"].get("initContainers", ()), *pod["spec"]["containers"])]


def serving() -> dict[str, Any]:
    return next(one for one in of_kind("Deployment") if one["metadata"]["name"] == "motionsplice")


def name_of(one: dict[str, Any]) -> str:
    metadata = one["metadata"]
    return f"{one['kind']} {metadata.get('name') or metadata['generateName']}"


@pytest.mark.parametrize("version", [OLDEST, NEWEST])
@pytest.mark.parametrize("document", documents(), ids=name_of)
def test_every_manifest_fits_the_published_schema(document: dict[str, Any], version: str) -> None:
    kubernetes_validate.validate(document, version, strict=True)


def test_the_schemas_know_a_wrong_field() -> None:
    (budget,) = of_kind("PodDisruptionBudget")
    budget["spec"]["maxUnavailible"] = 1
    with pytest.raises(kubernetes_validate.ValidationError):
        kubernetes_validate.validate(budget, NEWEST, strict=True)


def test_selectors_find_pods() -> None:
    labels = [pod["metadata"]["labels"] for pod in pods()]
    for one in of_kind("Deployment", "PodDisruptionBudget"):
        assert [found for found in labels if one["spec"]["selector"]["matchLabels"].items() <= found.items()]
    for one in of_kind("Service"):
        assert [found for found in labels if one["spec"]["selector"].items() <= found.items()]


def test_ports_mounts_and_accounts_that_are_named_exist() -> None:
    named = {port["name"] for one in containers() for port in one.get("ports", ())}
    assert {port["targetPort"] for one in of_kind("Service") for port in one["spec"]["ports"]} <= named
    accounts = {one["metadata"]["name"] for one in of_kind("ServiceAccount")}
    for pod in pods():
        volumes = {volume["name"] for volume in pod["spec"].get("volumes", ())}
        assert {mount["name"] for one in pod["spec"]["containers"] for mount in one["volumeMounts"]} == volumes
        assert pod["spec"].get("serviceAccountName", "motionsplice") in accounts


def test_containers_have_no_rights_that_they_do_not_need() -> None:
    for one in containers():
        assert one["securityContext"] == {
            "allowPrivilegeEscalation": False,
            "readOnlyRootFilesystem": True,
            "capabilities": {"drop": ["ALL"]},
        }
        assert one["resources"]["limits"]["memory"]
    assert all(pod["spec"]["securityContext"]["runAsNonRoot"] for pod in pods())


def test_the_autoscaler_scales_the_service_by_a_metric_that_the_rule_makes_of_the_services_own() -> None:
    (scaler,), (rules,) = of_kind("HorizontalPodAutoscaler"), of_kind("ConfigMap")
    target = scaler["spec"]["scaleTargetRef"]
    assert f"{target['kind']} {target['name']}" in map(name_of, documents())
    (rule,) = yaml.safe_load(rules["data"]["config.yaml"])["rules"]
    (metric,) = scaler["spec"]["metrics"]
    assert metric["pods"]["metric"]["name"] == rule["name"]["as"] == "motionsplice_tick_lateness"
    metrics = Metrics()
    metrics.tick_lateness.observe(0.001)
    series = rule["seriesQuery"].partition("{")[0]
    assert f"\n{series}{{le=" in metrics.render()[0].decode()
    assert "histogram_quantile(0.95," in rule["metricsQuery"]


def test_links_to_services_do_not_reach_the_settings() -> None:
    names = {one["metadata"]["name"].upper().replace("-", "_") for one in of_kind("Service")}
    linked = {f"{name}_{end}" for name in names for end in ("SERVICE_HOST", "SERVICE_PORT", "PORT")}
    assert linked & {variable(name) for name in Settings.model_fields} == {"MOTIONSPLICE_PORT"}
    assert serving()["spec"]["template"]["spec"]["enableServiceLinks"] is False


def test_prometheus_is_told_to_send_the_token_to_the_pods() -> None:
    monitor, configuration = (yaml.safe_load(found) for found in SNIPPET.findall((DEPLOY / "README.md").read_text()))
    pod = serving()["spec"]["template"]
    (container,) = pod["spec"]["containers"]
    assert "annotations" not in pod["metadata"]  # Prometheus would scrape by them without the token
    (endpoint,) = monitor["spec"]["podMetricsEndpoints"]
    (token,) = [one["valueFrom"]["secretKeyRef"] for one in container["env"] if one["name"] == "MOTIONSPLICE_TOKEN"]
    assert endpoint["authorization"] == {"type": "Bearer", "credentials": token}
    assert endpoint["port"] in {port["name"] for port in container["ports"]}
    assert monitor["spec"]["selector"] == serving()["spec"]["selector"]
    (job,) = configuration["scrape_configs"]
    assert job["authorization"]["type"] == "Bearer"
    assert {rule["target_label"] for rule in job["relabel_configs"] if "target_label" in rule} == {"namespace", "pod"}
    assert endpoint["path"] == job["metrics_path"] == "/metrics"


def test_commands_have_the_flags_that_are_used() -> None:
    ours = [one["args"] for one in containers() if "args" in one]
    assert sorted(command[0] for command in ours) == ["precompute", "serve"]
    for command, *arguments in ours:
        shown = CliRunner().invoke(app, [command, "--help"], env={"COLUMNS": "200", "NO_COLOR": "1"}).output
        assert {flag for flag in arguments if flag.startswith("--")} <= set(re.findall(r"--[\w-]+", shown))


def test_workers_the_scheduler_and_the_job_are_of_one_image() -> None:
    assert len({one["image"] for one in containers()}) == 1
    words = [word for one in containers() for word in (*one.get("command", ()), *one.get("args", ()))]
    addresses = {word for word in words if word.startswith("tcp://")}
    service = next(one for one in of_kind("Service") if one["metadata"]["name"] == "motionsplice-dask")
    assert addresses == {f"tcp://motionsplice-dask:{service['spec']['ports'][0]['port']}"}
