"""The pydantic-ai model behind an endpoint, and one exchange with it. Imported when the first question is asked."""

import ssl
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from enum import StrEnum
from typing import Any

from openai import AsyncOpenAI, DefaultAsyncHttpxClient
from openai.types import chat
from pydantic_ai.direct import model_request
from pydantic_ai.messages import ModelRequest, TextPart, ToolCallPart, UserPromptPart
from pydantic_ai.models import Model, ModelRequestParameters
from pydantic_ai.models.openai import OpenAIChatModel
from pydantic_ai.output import OutputObjectDefinition
from pydantic_ai.providers.openai import OpenAIProvider
from pydantic_ai.settings import ModelSettings
from pydantic_ai.tools import ToolDefinition

from lpslam.language.hosted.endpoint import Endpoint

_ANSWER = "answer"
_MOST_ANSWERED = 4000  # tokens; an answer has about a hundred, a model that thinks first uses more


class Mode(StrEnum):
    """How a server is asked to keep to a schema, the strictest first."""

    SCHEMA = "schema"
    TOOL = "tool"
    PLAIN = "plain"


@asynccontextmanager
async def connect(endpoint: Endpoint) -> AsyncIterator[Model]:
    """Open the model; its connections belong to the running event loop and are closed on leaving.

    Raises:
        ImportError: the provider's own library is not installed.
    """
    if endpoint.protocol == "anthropic":
        from anthropic import AsyncAnthropic
        from pydantic_ai.models.anthropic import AnthropicModel
        from pydantic_ai.providers.anthropic import AnthropicProvider

        async with AsyncAnthropic(api_key=endpoint.key, base_url=endpoint.base_url, max_retries=0) as client:
            # Messages to Anthropic need a limit; without one the largest is sent, and the answer comes as a stream.
            settings = ModelSettings(max_tokens=_MOST_ANSWERED)
            yield AnthropicModel(endpoint.model, provider=AnthropicProvider(anthropic_client=client), settings=settings)
    elif endpoint.protocol == "google":
        from pydantic_ai.models.google import GoogleModel
        from pydantic_ai.providers.google import GoogleProvider

        google = GoogleModel(endpoint.model, provider=GoogleProvider(api_key=endpoint.key, base_url=endpoint.base_url))
        async with google:
            yield google
    else:
        # Retrying is the exchange's own; a library that retries as well would multiply it.
        async with AsyncOpenAI(
            api_key=endpoint.key or "none",
            base_url=endpoint.base_url,
            max_retries=0,
            http_client=_plain_client() if endpoint.base_url.startswith("http://") else None,
        ) as openai:
            if endpoint.label.partition(":")[0] != "openai":
                # Set for OpenAI in the environment; no other server needs to know them.
                openai.organization = openai.project = None
            yield _LenientChatModel(endpoint.model, provider=OpenAIProvider(openai_client=openai))


def _plain_client() -> DefaultAsyncHttpxClient:
    """For a server at home: reading the authorities of all the world takes longer than asking it; none is trusted."""
    return DefaultAsyncHttpxClient(verify=ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT))


async def put(model: Model, system: str, user: str, schema: Mapping[str, Any], mode: Mode) -> tuple[str, int]:
    """Put one question; return what was answered, and the tokens used (0 where the server does not say).

    Raises:
        pydantic_ai.exceptions.AgentRunError, UserError: as pydantic-ai raises them.
    """
    request = ModelRequest(parts=[UserPromptPart(user)], instructions=system)
    response = await model_request(model, [request], model_request_parameters=_parameters(schema, mode))
    calls = [part.args_as_json_str() for part in response.parts if isinstance(part, ToolCallPart)]
    texts = [part.content for part in response.parts if isinstance(part, TextPart)]
    return calls[0] if calls else "".join(texts), response.usage.input_tokens + response.usage.output_tokens


def _parameters(schema: Mapping[str, Any], mode: Mode) -> ModelRequestParameters:
    if mode is Mode.SCHEMA:
        form = OutputObjectDefinition(json_schema=dict(schema), name=_ANSWER, strict=True)
        return ModelRequestParameters(output_mode="native", output_object=form)
    if mode is Mode.TOOL:
        tool = ToolDefinition(name=_ANSWER, parameters_json_schema=dict(schema), description="Give the answer.")
        return ModelRequestParameters(output_mode="tool", output_tools=[tool], allow_text_output=False)
    return ModelRequestParameters()


class _LenientChatModel(OpenAIChatModel):
    """Takes completions of small servers, which leave out fields that say nothing about the answer."""

    def _validate_completion(self, response: chat.ChatCompletion) -> Any:
        usual = {"id": "", "created": 0, "model": self.model_name, "object": "chat.completion"}
        choices = [
            choice.model_copy(update=_missing(choice, {"index": index, "finish_reason": "stop"}))
            for index, choice in enumerate(response.choices or ())
        ]
        update = {**_missing(response, usual), "choices": choices}
        return super()._validate_completion(response.model_copy(update=update))


def _missing(given: object, usual: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in usual.items() if getattr(given, name, None) is None}
