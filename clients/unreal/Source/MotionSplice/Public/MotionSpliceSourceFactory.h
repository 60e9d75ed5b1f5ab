// The entry "motionsplice" in Live Link's menu of sources.
#pragma once

#include "CoreMinimal.h"
#include "LiveLinkSourceFactory.h"
#include "MotionSpliceSourceFactory.generated.h"

UCLASS()
class MOTIONSPLICE_API UMotionSpliceSourceFactory : public ULiveLinkSourceFactory
{
	GENERATED_BODY()

public:
	using ULiveLinkSourceFactory::CreateSource; // newer engines have a second one, which calls the one below

	virtual FText GetSourceDisplayName() const override;
	virtual FText GetSourceTooltip() const override;
	virtual EMenuType GetMenuType() const override { return EMenuType::MenuEntry; }

	/** Creates a source. The connection string is not used: the source's settings say what it plays. */
	virtual TSharedPtr<ILiveLinkSource> CreateSource(const FString& ConnectionString) const override;
};
