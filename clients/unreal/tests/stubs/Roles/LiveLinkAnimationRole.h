#pragma once
#include "CoreMinimal.h"

class ULiveLinkRole : public UObject
{
	GENERATED_BODY()
};
class ULiveLinkAnimationRole : public ULiveLinkRole
{
	GENERATED_BODY()
};
